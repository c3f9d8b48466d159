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

CAMERA_KEYS, PATH_KEYS = (0x1_000C, 0x2_000C), (0x3_000C, 0x4_000C)
"""Keep both blocks of a pixel apart, and from the samples that make the picture."""
VERTICES = 2
"""Number of vertices of a path, from the camera on, whose shadow rays teach."""


@dataclass(frozen=True)
class Paths:
    """Paths along which lights were tried."""

    pixel: Indices
    """(paths,): pixel (grid) of each."""
    radiance: Floats
    """(paths,): mean over the channels of its radiance."""
    block: int
    """Paths of a pixel that follow each other in the sampler's sequence. A pixel has two such blocks with sequences of
    their own: the difference tells how wrong a picture with so many samples is."""


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


def trained_pixels(pixel_count: int, path_count: int, block: int) -> tuple[Indices, Indices, Indices]:
    """Return (pixel, sequence, sample index) of about ``path_count`` paths, spread evenly over ``pixel_count`` pixels.

    For each pixel there are ``block`` paths of the sequence 0, and then as many of the sequence 1. Where pixels are few
    they come again, with the next samples. With n times as many paths every n-th pixel is one of those before.
    """
    trained = max(path_count // (2 * block), 1)
    pixel = (np.arange(trained, dtype=np.uint64) * np.uint64(pixel_count) // np.uint64(trained)).astype(np.uint32)
    again = np.arange(trained) - np.searchsorted(pixel, pixel)
    index = (again[:, None, None] * block + np.arange(block)).astype(np.uint32)
    shape = trained, 2, block
    sequence = np.arange(2, dtype=np.uint32)[:, None]
    parts = pixel[:, None, None], sequence, index
    pixels, sequences, indices = (np.broadcast_to(part, shape).ravel() for part in parts)
    return pixels, sequences, indices


def joined(first: Trials, path_count: int, second: Trials) -> Trials:
    """Return the trials of two trainings, the first of which had ``path_count`` paths."""
    later = replace(second, path=second.path + np.uint32(path_count))
    return Trials(**{name: np.concatenate([getattr(first, name), values]) for name, values in vars(later).items()})


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

    def train(self, table: LightTable, seed: int, training: int, path_count: int, block: int) -> tuple[Paths, Trials]:
        """Follow paths whose lights a table chooses, and return what these gave.

        The paths are the same for the same seed and number of ``training``, from 0. Their rays of the camera are the
        same for the same seed: what the camera's rays hit makes no difference between trainings.
        """
        view = self.held[0]
        chosen = trained_pixels(view.pixel_count, path_count, block)
        inputs = keys_of(seed, training), *(upload(mi.UInt32, values) for values in chosen)
        view.integrator.table = table  # an input of the recording, as all that it refers to
        brightness, lessons = self.call(*inputs)
        trials = [trials_of(lesson) for lesson in lessons]
        values = doubles(dr.select(dr.isfinite(brightness), brightness, 0.0))
        return Paths(chosen[0], values, block), Trials(
            *(np.concatenate(arrays) for arrays in zip(*trials, strict=True))
        )


def keys_of(seed: int, training: int) -> Any:
    """Return the keys (mi.UInt32, 4) of the camera's sequences of both blocks, and those of what comes after it."""
    keys = [seed ^ key for key in (*CAMERA_KEYS, *(key + training for key in PATH_KEYS))]
    return upload(mi.UInt32, np.array([key & 0xFFFFFFFF for key in keys], np.uint32))


def seeded_rays(view: View, sampler: Any, keys: Any, pixel: Any, sequence: Any, index: Any) -> tuple[Any, Any]:
    """Return (rays, weights) of the paths of ``trained_pixels`` (mi.UInt32), and let a sampler draw what comes after.

    ``keys``: from ``keys_of``.
    """
    sampler.seed_samples(dr.gather(mi.UInt32, keys, sequence), pixel, index)
    ray, weight, _ = camera_rays(view, sampler, pixel, dr.opaque(mi.Float, 1.0))
    of_camera = mi.UInt32(sampler.dimension)
    sampler.seed_samples(dr.gather(mi.UInt32, keys, 2 + sequence), pixel, index)
    sampler.dimension = of_camera
    return ray, weight


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
