"""Follow the paths from which a guide learns, and those that show how much it has learned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Indices
from tracer.core.device import to_host, upload
from tracer.guiding.chosen import Chosen
from tracer.guiding.table import LightTable
from tracer.sampling.recordable import Recordable
from tracer.sampling.samples import camera_rays
from tracer.scene.view import View

CAMERA_KEYS, PATH_KEYS = (0x1_000C, 0x2_000C), (0x3_000C, 0x4_000C)
"""Keep both sequences of a pixel apart, and from the samples that make the picture."""
VERTICES = 2
"""Number of vertices of a path, from the camera on, whose shadow rays teach."""


@dataclass(frozen=True)
class Paths:
    """Paths along which lights were tried: first those that judge, then those that teach."""

    chosen: Chosen
    radiance: Floats
    """(paths,): mean over the channels of the radiance of each."""

    @property
    def blocks(self) -> Floats:
        """(pixels, 2, block): radiance of paths that judge."""
        return self.radiance[: self.chosen.judge_count].reshape(-1, 2, self.chosen.block)

    @property
    def teachers(self) -> Floats:
        """(paths,): radiance of paths that teach; two and two are of the same pixel."""
        return self.radiance[self.chosen.judge_count :]


@dataclass(frozen=True)
class Trials:
    """Shadow rays of paths, each to a light that was chosen at random."""

    path: Indices
    """(N,): path of each, among those that teach."""
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


def joined(parts: Sequence[Trials]) -> Trials:
    """Return trials one after another."""
    return Trials(*(np.concatenate(arrays) for arrays in zip(*(vars(part).values() for part in parts), strict=True)))


class Trainer(Recordable):
    """Follows paths of one view, in a recording for all tables by which lights are chosen."""

    def __init__(self, view: View, sampler: Any) -> None:
        """``view``: with the integrator ``guided``."""
        held = [view, sampler]

        def trace(keys: Any, pixel: Any, sequence: Any, index: Any) -> tuple[Any, Any]:
            view, sampler = held
            sampler = sampler.fork()
            ray, weight = seeded_rays(view, sampler, keys, pixel, sequence, index)
            radiance, valid, lessons = view.integrator.follow(view.scene, sampler, ray, mi.Bool(True), VERTICES)
            brightness = dr.mean(mi.unpolarized_spectrum(dr.select(valid, weight * radiance, 0.0)))
            dr.eval(brightness, lessons)
            return brightness, lessons

        super().__init__(held, trace)

    def train(self, table: LightTable, seed: int, training: int, chosen: Chosen) -> tuple[Paths, list[Trials]]:
        """Follow paths whose lights a table chooses; return what they gave, and the trials at each of their vertices.

        The paths are the same for the same seed and number of ``training``, from 0. The same samples have the same rays
        of the camera in all trainings with a seed: what these rays hit makes no difference between trainings.
        """
        arrays = (upload(mi.UInt32, values) for values in (chosen.pixel, chosen.sequence, chosen.index))
        self.held[0].integrator.table = table  # an input of the recording, as all that it refers to
        brightness, lessons = self.call(keys_of(seed, training), *arrays)
        trials = [trials_of(lesson, chosen.judge_count) for lesson in lessons]
        return Paths(chosen, doubles(dr.select(dr.isfinite(brightness), brightness, 0.0))), trials


def keys_of(seed: int, training: int) -> Any:
    """Return the keys (mi.UInt32, 4) of both sequences of the camera, and of both of what comes after it."""
    keys = [seed ^ key for key in (*CAMERA_KEYS, *(key + training for key in PATH_KEYS))]
    return upload(mi.UInt32, np.array([key & 0xFFFFFFFF for key in keys], np.uint32))


def seeded_rays(view: View, sampler: Any, keys: Any, pixel: Any, sequence: Any, index: Any) -> tuple[Any, Any]:
    """Return (rays, weights) of samples (mi.UInt32), as of ``Chosen``, and let a sampler draw what comes after.

    ``keys``: from ``keys_of``.
    """
    sampler.seed_samples(dr.gather(mi.UInt32, keys, sequence), pixel, index)
    ray, weight, _ = camera_rays(view, sampler, pixel, dr.opaque(mi.Float, 1.0))
    of_camera = mi.UInt32(sampler.dimension)
    sampler.seed_samples(dr.gather(mi.UInt32, keys, 2 + sequence), pixel, index)
    sampler.dimension = of_camera
    return ray, weight


def trials_of(lesson: Any, judge_count: int) -> Trials:
    """Return the trials at one vertex of all paths but the first ``judge_count``; ``lesson``: a ``LightSample``."""
    teaches = dr.arange(mi.UInt32, dr.width(lesson.slot)) >= judge_count
    is_finite = dr.all(dr.isfinite(lesson.position) & dr.isfinite(lesson.normal))
    path = dr.compress(lesson.taught & teaches & is_finite)
    if len(path) == 0:
        none, nowhere, numbers = np.zeros(0), np.zeros((0, 3)), np.zeros(0, np.uint32)
        return Trials(numbers, nowhere, nowhere, numbers, none, none)

    def taken(values: Any) -> Any:
        return dr.gather(type(values), values, path)

    given = taken(lesson.given)
    return Trials(
        path=to_host(path, (-1,)) - np.uint32(judge_count),
        position=rows_of(taken(lesson.position)),
        normal=rows_of(taken(lesson.normal)),
        slot=to_host(taken(lesson.slot), (-1,)),
        chance=doubles(taken(lesson.chance)),
        given=doubles(dr.select(dr.isfinite(given), given, 0.0)),
    )


def doubles(values: Any) -> Floats:
    """Return an mi.Float as float64."""
    return to_host(values, (-1,)).astype(np.float64)


def rows_of(vectors: Any) -> Floats:
    """Return an mi.Vector3f as (N, 3) float64."""
    return np.stack([doubles(values) for values in vectors], axis=-1)
