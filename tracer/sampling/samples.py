"""Draw samples: a list of (pixel, sample index) to radiance, on the device."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import drjit as dr
import mitsuba as mi

from tracer.core.device import divide
from tracer.scene.view import View

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Samples:
    """What a pass has drawn, one entry a lane."""

    values: list[Any]
    """mi.Float per channel of the image."""
    position: Any
    """mi.Point2f: place of the sample within its pixel, in [0, 1)^2."""
    rays: Any
    """mi.Float: rays that the sample is taken to have traced, see ``rays_of``."""
    moments: list[Any] = field(default_factory=list)
    """mi.Float per quantity whose mean over a pixel a criterion asked for."""
    peaks: list[Any] = field(default_factory=list)
    """mi.Float per quantity whose maximum over a pixel a criterion asked for."""


Moments = Callable[[list[Any], Any], tuple[list[Any], list[Any]]]
"""From the colour of a sample (mi.Float per channel) and its index (mi.UInt32) to ``moments`` and ``peaks``."""


def make_sampler() -> Any:
    """Return a new sampler of the kind that every sample is drawn with."""
    return mi.load_dict({"type": "owen_sobol"})


def camera_ray(view: View, sampler: Any, row: Any, column: Any) -> tuple[Any, Any, Any]:
    """Return (ray, weight, position within the pixel) for the next sample of pixels of ``view.grid``.

    Draws dimensions in Mitsuba's own order (film, aperture, time, wavelength), so that a sample equals the one that
    ``mi.render`` takes with the same sampler.
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
    sampler: Any,
    seed: Any,
    pixel: Any,
    index: Any,
    differential_scale: Any,
    moments: Moments | None = None,
) -> Samples:
    """Draw sample ``index`` of pixel ``pixel`` (both mi.UInt32, one entry a lane); nothing is evaluated.

    ``differential_scale`` shrinks ray differentials, 1 / sqrt(spp) as in ``mi.render``.
    """
    sampler.seed_samples(seed, pixel, index)
    shot = shoot(view, sampler, pixel, differential_scale)
    return follow(view, sampler, shot, index, moments)


def shoot(view: View, sampler: Any, pixel: Any, differential_scale: Any) -> tuple[Any, Any, Any]:
    """Return ``camera_ray`` of each pixel, its differentials scaled."""
    row, column = divide(pixel, view.grid[1])
    ray, weight, position = camera_ray(view, sampler, row, column)
    ray.scale_differential(differential_scale)
    return ray, weight, position


def follow(view: View, sampler: Any, shot: tuple[Any, Any, Any], index: Any, moments: Moments | None) -> Samples:
    """Return the samples along the rays of ``shoot``."""
    ray, weight, position = shot
    of_camera = mi.UInt32(sampler.dimension)
    radiance, valid, aovs = sample_radiance(view, sampler, ray)
    values = view.to_channels(weight * radiance, valid, ray.wavelengths)
    extra = moments(values[: view.colour_channels], index) if moments is not None else ([], [])
    return Samples([*values, *aovs], position, rays_of(sampler.dimension - of_camera), *extra)


def moment_counts(view: View, moments: Moments | None) -> tuple[int, int]:
    """Return how many moments and peaks a criterion asks for."""
    if moments is None:
        return 0, 0
    means, peaks = moments([mi.Float(1.0)] * view.colour_channels, mi.UInt32(0))
    return len(means), len(peaks)


def rays_of(dimensions: Any) -> Any:
    """Return the rays of a path (mi.Float) from the dimensions (mi.UInt32) that its integrator drew.

    Mitsuba's ``path`` draws four a vertex, for an emitter, a lobe, a direction and roulette, those of the vertex where
    it ends included; and it traces a ray to each vertex and, but for the last, one to an emitter: 2 k - 1 rays for k
    vertices. An integrator that draws the same number along every path is taken to cost the same everywhere.
    """
    return dr.maximum(0.5 * mi.Float(dimensions) - 1.0, 1.0)


HIDES_ARRAYS = ("ThinLensCamera",)
"""Cameras of Mitsuba 3.9 that hide arrays from Dr.Jit."""


class Recorded:
    """``draw`` of one view as a function of (seed, pixel, index, differential_scale).

    It evaluates what it returns. Dr.Jit traces it once or twice and then launches the kernels it recorded: to trace a
    scene of many shapes takes as long as to draw 10^5 samples. ``pixel`` and ``index`` may be of any width. What uses a
    plugin that hides arrays from Dr.Jit cannot be recorded: the rays of such a camera are traced for every pass and
    handed over, and if something else hides them, everything is; as that is found out only when the first pass was
    drawn for nothing, cameras known to do so (HIDES_ARRAYS) are not tried.
    """

    def __init__(self, view: View, sampler: Any, moments: Moments | None = None) -> None:
        held = [view, sampler]

        def trace(seed: Any, pixel: Any, index: Any, last: Any) -> tuple[Any, ...]:
            view, sampler = held
            # A fork, as the sampler is an input of the recording: arrays left in it by the last pass would be too.
            sampler = sampler.fork()
            sampler.seed_samples(seed, pixel, index)
            if isinstance(last, tuple):
                sampler.dimension, shot = mi.UInt32(last[0]), last[1:]  # a copy: loops change it in place
            else:
                shot = shoot(view, sampler, pixel, last)
            samples = follow(view, sampler, shot, index, moments)
            drawn = (samples.values, samples.position, samples.rays, samples.moments, samples.peaks)
            dr.eval(drawn)
            return drawn

        self.held, self.trace, self.record = held, trace, dr.freeze(trace)
        self.recordable = True
        self.records_camera = view.sensor.class_name() not in HIDES_ARRAYS

    def __call__(self, seed: Any, pixel: Any, index: Any, differential_scale: Any) -> Samples:
        """Draw, see ``draw`` for the arguments."""
        last = differential_scale if self.records_camera else self.shoot(seed, pixel, index, differential_scale)
        dr.eval(seed, pixel, index, last)
        if self.recordable:
            try:
                return Samples(*self.record(seed, pixel, index, last))
            except RuntimeError as error:  # tracing finds the error again, if it is another one
                self.recordable = False
                logger.info("Every pass is traced anew, as the scene cannot be recorded: %s", error)
        return Samples(*self.trace(seed, pixel, index, last))

    def shoot(self, seed: Any, pixel: Any, index: Any, differential_scale: Any) -> tuple[Any, ...]:
        """Return the dimension that follows those of the camera, and its rays."""
        view, sampler = self.held[0], self.held[1].fork()
        sampler.seed_samples(seed, pixel, index)
        shot = shoot(view, sampler, pixel, differential_scale)
        found = mi.UInt32(sampler.dimension), *shot
        dr.make_opaque(found)  # a literal of another width would be another input, and recorded once more
        return found

    def close(self) -> None:
        """Let go of scene and kernels: a frozen function is part of a reference cycle and would keep them."""
        self.record.clear()
        self.held.clear()


def sample_radiance(view: View, sampler: Any, ray: Any) -> tuple[Any, Any, list[Any]]:
    """Return (radiance, valid, AOVs) along rays; Mitsuba's Python integrators have an interface of their own."""
    if isinstance(view.integrator, mi.CppADIntegrator):
        nothing = {"depth": mi.UInt32(0), "δL": None, "δaovs": None, "state_in": None, "active": mi.Bool(True)}
        primal = dr.ADMode.Primal
        return view.integrator.sample(mode=primal, scene=view.scene, sampler=sampler, ray=ray, **nothing)[:3]
    return view.integrator.sample(view.scene, sampler, ray, view.sensor.get_medium())
