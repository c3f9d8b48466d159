"""Features: what the camera's rays hit first, filtered like the picture, for denoisers and compositors."""

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
"""Most rays per pixel by default. The albedo of the bundled scenes is then off by 0.001 to 0.004 and the normal by
0.002 to 0.006 (RMS). In pictures of a megapixel the rays take 5 to 15 % of the time of 64 paths per pixel."""


@dataclass(frozen=True)
class Features:
    """What is seen in each pixel; ``plugins/features.py`` documents it in detail."""

    albedo: Singles
    """(H, W, 3): linear sRGB, 0 to 1; for emitters, their clipped radiance. Grey under monochromatic variants."""
    normal: Singles
    """(H, W, 3): mean of the shading normals in world space, length 0 to 1; 0 where nothing is seen."""
    depth: Singles
    """(H, W): mean distance along the ray from the camera's near plane, in units of the scene; a miss counts 0."""


@dataclass(frozen=True)
class FeatureView(View):
    """A view through the integrator ``features``, with its AOVs as only channels, as its radiance is 0."""

    filtered: bool = True
    """Whether features go through the film's filter, rather than each pixel by itself."""

    @cached_property
    def reach(self) -> int:  # type: ignore[override]
        """Distance in pixels over which a sample counts: 0 if it is not ``filtered``."""
        return super().reach if self.filtered else 0

    @cached_property
    def channels(self) -> list[str]:  # type: ignore[override]
        """Names of the AOVs."""
        return list(self.integrator.aov_names())

    def to_channels(self, spectrum: Any, valid: Any, wavelengths: Any) -> list[Any]:
        """Return no channels, as radiance and alpha are left out."""
        return []


def draw_features(
    view: View, sampler: Any, seed: int, counts: NDArray[np.uint32], most: int = MOST, filtered: bool = True
) -> Features:
    """Return the features along the camera rays of samples 0 to min(counts, most) - 1 of each pixel.

    These rays are those of a picture that has ``counts`` (``view.grid``) samples of ``seed``, drawn from ``sampler``
    (an ``owen_sobol``, whose state stays as it is). ``filtered``: whether features go through the film's filter, like
    the picture; if not, each pixel is taken by itself, as ``tracer.denoising.oidn`` needs it, in half the time and with
    less memory. A pixel to which no sample contributes is 0.
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
    """Return the number of the shape that the ray through the middle of each pixel hits (H, W), and all shapes' names.

    Numbers count from 1 in the order of ``scene.shapes()``, and the shape of number n has the name at index n - 1; 0
    means that the ray hits nothing. An instance counts as one shape. The name is the id of the shape, or the class of a
    shape that has lost its id, such as meshes that Mitsuba has merged.
    """
    height, width = view.size
    row, column = divide(dr.arange(mi.UInt32, height * width), width)
    middle = mi.Point2f(mi.Float(column) + 0.5, mi.Float(row) + 0.5) / mi.ScalarVector2f(view.film.crop_size())
    time = mi.Float(view.sensor.shutter_open() + 0.5 * view.sensor.shutter_open_time())
    ray, _ = view.sensor.sample_ray(time, mi.Float(0.5), middle, mi.Point2f(0.5))
    intersection = view.scene.ray_intersect_preliminary(ray, coherent=True)
    instance, shape = numbers_hit(intersection)
    number = dr.select(instance != 0, instance, shape)
    shapes = view.scene.shapes()
    table = table_by_shape(shapes, np.arange(1, len(shapes) + 1))
    is_known = intersection.is_valid() & (number < dr.width(table))
    numbers = dr.gather(mi.UInt32, table, number, is_known)
    return np.asarray(numbers.numpy()).reshape(height, width), [shape.id() or shape.class_name() for shape in shapes]
