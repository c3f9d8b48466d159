"""Draw the samples from which a guide learns: a few paths, along which all lights have the same chance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Indices
from tracer.core.device import to_host, upload
from tracer.guiding.table import LightTable
from tracer.sampling.recordable import Recordable
from tracer.sampling.samples import camera_rays
from tracer.scene.view import View

VERTICES = 2
"""Number of vertices of a path, from the camera on, whose shadow rays teach."""


@dataclass(frozen=True)
class Paths:
    """Paths along which lights were tried."""

    pixel: Indices
    """(paths,): pixel (grid) of each."""
    radiance: Floats
    """(paths,): mean over the channels of its radiance."""


@dataclass(frozen=True)
class Trials:
    """Shadow rays of paths, each to a light that was chosen at random."""

    path: Indices
    """(N,): path of each; those of a path follow each other by less than the number of paths."""
    position: Floats
    """(N, 3): where the shadow ray begins."""
    normal: Floats
    """(N, 3): normal of the surface there."""
    slot: Indices
    """(N,): slot that was chosen."""
    chance: Floats
    """(N,): with which chance it was chosen."""
    given: Floats
    """(N,): what it would have given to the pixel if the choice had been certain, mean over the channels."""


def trained_pixels(pixel_count: int, path_count: int) -> tuple[Indices, Indices]:
    """Return (pixel, sample index) of about ``path_count`` paths, spread evenly over ``pixel_count`` pixels.

    Each pixel has an even number of paths, next to each other, or none. Two and two have the same ray of the camera:
    their difference is noise of the light alone, and not what an edge makes of it.
    """
    spp = 2 * max(path_count // (2 * pixel_count), 1)
    trained = min(max(path_count // spp, 1), pixel_count)
    pixel = (np.arange(trained, dtype=np.uint64) * np.uint64(pixel_count) // np.uint64(trained)).astype(np.uint32)
    return np.repeat(pixel, spp), np.tile(np.arange(spp, dtype=np.uint32), trained)


def joined(first: Trials, path_count: int, second: Trials) -> Trials:
    """Return the trials of two trainings, the first of which had ``path_count`` paths."""
    later = replace(second, path=second.path + np.uint32(path_count))
    return Trials(**{name: np.concatenate([getattr(first, name), values]) for name, values in vars(later).items()})


class Trainer(Recordable):
    """Follows paths of one view, in a recording for all tables by which lights are chosen."""

    def __init__(self, view: View, sampler: Any) -> None:
        """``view``: with the integrator ``guided``."""
        held = [view, sampler]

        def trace(key: Any, pixel: Any, index: Any) -> tuple[Any, Any]:
            view, sampler = held
            sampler = sampler.fork()
            sampler.seed_samples(key, pixel, index >> 1)
            ray, weight, _ = camera_rays(view, sampler, pixel, dr.opaque(mi.Float, 1.0))
            of_camera = mi.UInt32(sampler.dimension)
            sampler.seed_samples(key, pixel, index)
            sampler.dimension = of_camera
            radiance, valid, lessons = view.integrator.follow(view.scene, sampler, ray, mi.Bool(True), VERTICES)
            brightness = dr.mean(mi.unpolarized_spectrum(dr.select(valid, weight * radiance, 0.0)))
            dr.eval(brightness, lessons)
            return brightness, lessons

        super().__init__(held, trace)

    def train(self, table: LightTable, seed: int, path_count: int) -> tuple[Paths, Trials]:
        """Follow paths whose lights a table chooses, and return what these gave.

        The paths are the same for the same seed.
        """
        view = self.held[0]
        pixel, index = trained_pixels(view.pixel_count, path_count)
        inputs = dr.opaque(mi.UInt32, seed), upload(mi.UInt32, pixel), upload(mi.UInt32, index)
        view.integrator.table = table  # an input of the recording, as all that it refers to
        brightness, lessons = self.call(*inputs)
        trials = [trials_of(lesson) for lesson in lessons]
        values = doubles(dr.select(dr.isfinite(brightness), brightness, 0.0))
        return Paths(pixel, values), Trials(*(np.concatenate(arrays) for arrays in zip(*trials, strict=True)))


def trials_of(lesson: Any) -> list[NDArray]:
    """Return the fields of ``Trials`` of one vertex of all paths; ``lesson``: a ``LightSample``."""
    path = dr.compress(lesson.taught & dr.all(dr.isfinite(lesson.position) & dr.isfinite(lesson.normal)))
    if len(path) == 0:
        return [
            np.zeros((0, 3) if name in ("position", "normal") else 0, np.uint32 if name in ("path", "slot") else float)
            for name in Trials.__dataclass_fields__
        ]
    slot, chance, given = (
        dr.gather(type(values), values, path) for values in (lesson.slot, lesson.chance, lesson.given)
    )
    place, normal = (dr.gather(type(values), values, path) for values in (lesson.position, lesson.normal))
    given = dr.select(dr.isfinite(given), given, 0.0)
    return [
        to_host(path, (-1,)),
        rows_of(place),
        rows_of(normal),
        to_host(slot, (-1,)),
        doubles(chance),
        doubles(given),
    ]


def doubles(values: Any) -> Floats:
    """Return an mi.Float as float64."""
    return to_host(values, (-1,)).astype(np.float64)


def rows_of(vectors: Any) -> Floats:
    """Return an mi.Vector3f as (N, 3) float64."""
    return np.stack([doubles(values) for values in vectors], axis=-1)
