"""Draw samples on the device: from a list of (pixel, sample index) to radiance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import drjit as dr
import mitsuba as mi

from tracer.core.device import divide
from tracer.core.protocols import KeyedSampler
from tracer.sampling.recordable import Recordable
from tracer.sampling.work import vertices_of
from tracer.scene.view import View


@dataclass(frozen=True)
class Samples:
    """The samples of a pass, one entry per lane."""

    values: list[mi.Float]
    """One for each channel of the image."""
    position: mi.Point2f
    """Place of the sample within its pixel, in [0, 1)^2."""
    vertices: mi.Float
    """Number of vertices of the sample's path, see ``vertices_of``."""
    moments: list[mi.Float] = field(default_factory=list)
    """One for each quantity whose mean over a pixel a criterion asked for."""
    peaks: list[mi.Float] = field(default_factory=list)
    """One for each quantity whose maximum over a pixel a criterion asked for."""


CameraSample: TypeAlias = "tuple[mi.RayDifferential3f, mi.Spectrum, mi.Point2f]"
"""Ray of the camera, its weight, and the place of the sample within its pixel."""
Moments: TypeAlias = "Callable[[list[mi.Float], mi.UInt32], tuple[list[mi.Float], list[mi.Float]]]"
"""Function from the colour of a sample (per channel) and its index to ``moments`` and ``peaks`` of ``Samples``."""


def make_sampler() -> KeyedSampler:
    """Return a new sampler of the kind with which all samples are drawn."""
    return mi.load_dict({"type": "owen_sobol"})


def camera_ray(view: View, sampler: KeyedSampler, row: mi.UInt32, column: mi.UInt32) -> CameraSample:
    """Return (ray, weight, position within the pixel) for the next sample of the pixels at ``row`` and ``column``.

    Both count in ``view.grid``. Dimensions are drawn in Mitsuba's own order (film, aperture, time, wavelength), so that
    a sample equals the one that ``mi.render`` takes with the same sampler.
    """
    position = sampler.next_2d()
    corner = mi.Vector2f(mi.Vector2i(column, row) + view.grid_origin)
    scale = 1.0 / mi.ScalarVector2f(view.film.crop_size())
    film_position = (corner + position - mi.ScalarVector2f(view.film.crop_offset())) * scale

    sensor = view.sensor
    aperture = sampler.next_2d() if sensor.needs_aperture_sample() else mi.Point2f(0.5)
    time = mi.Float(sensor.shutter_open())
    if sensor.shutter_open_time() > 0:
        time += sampler.next_1d() * sensor.shutter_open_time()
    wavelength = sampler.next_1d() if mi.is_spectral else mi.Float(0.0)
    ray, weight = sensor.sample_ray_differential(time, wavelength, film_position, aperture)
    return ray, weight, position


def draw(
    view: View,
    sampler: KeyedSampler,
    seed: mi.UInt32,
    pixel: mi.UInt32,
    index: mi.UInt32,
    differential_scale: mi.Float,
    moments: Moments | None = None,
) -> Samples:
    """Draw sample ``index`` of pixel ``pixel`` (one entry per lane); nothing is evaluated.

    ``differential_scale``: factor that shrinks ray differentials, 1 / sqrt(spp) as in ``mi.render``.
    """
    sampler.seed_samples(seed, pixel, index)
    camera_sample = camera_rays(view, sampler, pixel, differential_scale)
    return follow(view, sampler, camera_sample, index, moments)


def camera_rays(view: View, sampler: KeyedSampler, pixel: mi.UInt32, differential_scale: mi.Float) -> CameraSample:
    """Return ``camera_ray`` of each pixel, with scaled differentials."""
    row, column = divide(pixel, view.grid[1])
    ray, weight, position = camera_ray(view, sampler, row, column)
    ray.scale_differential(differential_scale)
    return ray, weight, position


def follow(
    view: View, sampler: KeyedSampler, camera_sample: CameraSample, index: mi.UInt32, moments: Moments | None
) -> Samples:
    """Return the samples along the rays that ``camera_rays`` returned as ``camera_sample``."""
    ray, weight, position = camera_sample
    of_camera = mi.UInt32(sampler.dimension)
    radiance, valid, aovs = sample_radiance(view, sampler, ray)
    values = view.to_channels(weight * radiance, valid, ray.wavelengths)
    extra = moments(values[: view.colour_channels], index) if moments is not None else ([], [])
    return Samples([*values, *aovs], position, vertices_of(sampler.dimension - of_camera), *extra)


def moment_counts(view: View, moments: Moments | None) -> tuple[int, int]:
    """Return how many moments and peaks a criterion asks for."""
    if moments is None:
        return 0, 0
    means, peaks = moments([mi.Float(1.0)] * view.colour_channels, mi.UInt32(0))
    return len(means), len(peaks)


HIDES_ARRAYS = ("ThinLensCamera",)
"""Classes of the cameras of Mitsuba 3.9 that hide arrays from Dr.Jit, so that their rays cannot be recorded."""


class Recorded(Recordable):
    """``draw`` for one view, as a recorded function of (seed, pixel, index, differential_scale).

    It evaluates what it returns. Dr.Jit traces the function once or twice and then launches the kernels that it has
    recorded, as to trace a scene of many shapes takes as long as to draw 10^5 samples. ``pixel`` and ``index`` may have
    any width. Plugins that hide arrays from Dr.Jit cannot be recorded. If a camera hides them, its rays are traced anew
    for every pass and handed to the recording; if another plugin does, everything is traced anew. As that shows only
    after a first pass was drawn in vain, recording is not tried with cameras that are known to do so (HIDES_ARRAYS).
    """

    def __init__(self, view: View, sampler: KeyedSampler, moments: Moments | None = None) -> None:
        held: list[Any] = [view, sampler]

        def trace(seed: mi.UInt32, pixel: mi.UInt32, index: mi.UInt32, scale_or_camera_sample: Any) -> tuple[Any, ...]:
            view, sampler = held
            # The sampler is an input of the recording, and so would be arrays that the last pass left in it: so fork.
            sampler = sampler.fork()
            sampler.seed_samples(seed, pixel, index)
            if isinstance(scale_or_camera_sample, tuple):
                # The dimension is copied, as loops change it in place.
                sampler.dimension, camera_sample = mi.UInt32(scale_or_camera_sample[0]), scale_or_camera_sample[1:]
            else:
                camera_sample = camera_rays(view, sampler, pixel, scale_or_camera_sample)
            samples = follow(view, sampler, camera_sample, index, moments)
            drawn = (samples.values, samples.position, samples.vertices, samples.moments, samples.peaks)
            dr.eval(drawn)
            return drawn

        super().__init__(held, trace)
        self.records_camera = view.sensor.class_name() not in HIDES_ARRAYS

    def __call__(self, seed: mi.UInt32, pixel: mi.UInt32, index: mi.UInt32, differential_scale: mi.Float) -> Samples:
        """Draw samples; see ``draw`` for the arguments."""
        scale_or_camera_sample = (
            differential_scale if self.records_camera else self.camera_rays(seed, pixel, index, differential_scale)
        )
        dr.eval(seed, pixel, index, scale_or_camera_sample)
        return Samples(*self.call(seed, pixel, index, scale_or_camera_sample))

    def camera_rays(
        self, seed: mi.UInt32, pixel: mi.UInt32, index: mi.UInt32, differential_scale: mi.Float
    ) -> tuple[Any, ...]:
        """Return the first dimension that the camera does not draw, and what the function ``camera_rays`` returns."""
        view, sampler = self.held[0], self.held[1].fork()
        sampler.seed_samples(seed, pixel, index)
        camera_sample = camera_rays(view, sampler, pixel, differential_scale)
        inputs = mi.UInt32(sampler.dimension), *camera_sample
        dr.make_opaque(inputs)  # a literal of another width would be recorded once more
        return inputs


def sample_radiance(
    view: View, sampler: KeyedSampler, ray: mi.RayDifferential3f
) -> tuple[mi.Spectrum, mi.Bool, Sequence[mi.Float]]:
    """Return (radiance, valid, AOVs) along rays; Mitsuba's integrators in Python have an interface of their own."""
    if isinstance(view.integrator, mi.CppADIntegrator):
        nothing = {"depth": mi.UInt32(0), "δL": None, "δaovs": None, "state_in": None, "active": mi.Bool(True)}
        primal = dr.ADMode.Primal
        return view.integrator.sample(mode=primal, scene=view.scene, sampler=sampler, ray=ray, **nothing)[:3]
    return view.integrator.sample(view.scene, sampler, ray, view.sensor.get_medium())
