"""Features: what the camera's rays hit first, filtered as the picture is. Denoisers and compositors ask for them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Singles
from tracer.core.device import divide, numbers_hit, table_by_shape
from tracer.film.estimate import Estimate
from tracer.sampling import samples
from tracer.sampling.passes import PASS_SIZES, even_pass
from tracer.sampling.wavefront import lane_pixels, line_of
from tracer.scene.view import View

MOST = 32
"""Rays per pixel by default. The albedo of the bundled scenes is then off by 0.001 to 0.004 and the normal by 0.002 to
0.006 (RMS), and 128 rays improve denoised pictures by 2 % in squared error. In pictures of a megapixel they take 5 to
15 % of the time of 64 paths a pixel; unfiltered, 3 to 12 %."""


@dataclass(frozen=True)
class Features:
    """What is seen in each pixel; the documentation of ``plugins/features.py`` has more."""

    albedo: Singles
    """(H, W, 3): linear sRGB, 0 to 1; what shines has its radiance, clipped. Grey under monochromatic variants."""
    normal: Singles
    """(H, W, 3): mean of the shading normals in world space, length 0 to 1; 0 where nothing is seen."""
    depth: Singles
    """(H, W): mean distance along the ray, in units of the scene, from the camera's near plane; nothing counts 0."""


@dataclass(frozen=True)
class FeatureView(View):
    """The same view through the integrator ``features``, whose AOVs are all its channels: its radiance is 0."""

    filtered: bool = True
    """Whether through the film's filter, instead of each pixel by itself."""

    @cached_property
    def reach(self) -> int:  # type: ignore[override]
        """How many pixels away a sample counts."""
        return super().reach if self.filtered else 0

    @cached_property
    def channels(self) -> list[str]:  # type: ignore[override]
        """Names of the AOVs."""
        return list(self.integrator.aov_names())

    def to_channels(self, spectrum: Any, valid: Any, wavelengths: Any) -> list[Any]:
        """Leave out radiance and alpha."""
        return []


def draw_features(
    view: View, sampler: Any, seed: int, counts: NDArray[np.uint32], most: int = MOST, filtered: bool = True
) -> Features:
    """Return the features along the camera rays of samples 0 to min(counts, most) - 1 of each pixel.

    They are those of the picture that has ``counts`` (``view.grid``) samples of ``seed``, drawn from ``sampler`` (an
    ``owen_sobol``, which is left as it is). ``filtered``: through the film's filter, as the picture is; else each pixel
    by itself, as ``tracer.denoising.oidn`` needs it, for half the time and less memory. A pixel to which no sample
    gives anything is 0.
    """
    features = FeatureView(view.scene, view.sensor, mi.load_dict({"type": "features"}), {}, filtered)
    counts = np.minimum(counts, most).astype(np.uint32)
    estimate = Estimate(features)
    line = line_of(counts.ravel())
    with dr.suspend_grad():
        recorded = samples.Recorded(features, sampler.fork())
        key = dr.opaque(mi.UInt32, seed)
        scale = dr.opaque(mi.Float, max(most, 1) ** -0.5)
        while line.taken < line.total:
            window = line.take(even_pass(line.total - line.taken, PASS_SIZES[0]))
            pixel, index = lane_pixels(window)
            estimate.add(window, recorded(key, pixel, index, scale))
        recorded.close()
        image, _ = estimate.develop()
    return Features(image[..., :3], image[..., 3:6], image[..., 6])


def shape_numbers(view: View) -> tuple[NDArray[np.uint32], list[str]]:
    """Return the shape that the ray through the middle of each pixel hits (H, W), and the names of the shapes.

    Shapes count from 1, in the order of ``scene.shapes()``: number n has name n - 1. 0 is nothing. An instance counts
    as one shape. The name is the id, or the class of a shape that has lost it, as meshes do that Mitsuba has merged.
    """
    height, width = view.size
    row, column = divide(dr.arange(mi.UInt32, height * width), width)
    middle = mi.Point2f(mi.Float(column) + 0.5, mi.Float(row) + 0.5) / mi.ScalarVector2f(view.film.crop_size())
    time = mi.Float(view.sensor.shutter_open() + 0.5 * view.sensor.shutter_open_time())
    ray, _ = view.sensor.sample_ray(time, mi.Float(0.5), middle, mi.Point2f(0.5))
    found = view.scene.ray_intersect_preliminary(ray, coherent=True)
    instance, shape = numbers_hit(found)
    number = dr.select(instance != 0, instance, shape)
    shapes = view.scene.shapes()
    table = table_by_shape(shapes, np.arange(1, len(shapes) + 1))
    known = found.is_valid() & (number < dr.width(table))
    order = dr.gather(mi.UInt32, table, number, known)
    return np.asarray(order.numpy()).reshape(height, width), [shape.id() or shape.class_name() for shape in shapes]
