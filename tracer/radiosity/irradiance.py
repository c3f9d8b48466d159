"""Irradiance of points: rays of each hemisphere, each of which stands for a part of it.

E(x) is the integral of L cos over the hemisphere. Of rays that go as a density q times that of the cosine, j stands for
w_j = pi / (N q_j), and E = sum_j w_j L_j; in strata, for Omega'_T / n_T. Its expectation is E wherever the rays go.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.device import divide, upload
from tracer.radiosity.groups import Groups
from tracer.radiosity.hemisphere import MOST_RAYS, See
from tracer.radiosity.lattice import Way, evenly

Integers = NDArray[np.int64]
Chosen = NDArray[np.bool_]


@dataclass(frozen=True)
class Gathered:
    """Irradiance and what it took."""

    irradiance: Floats
    """(P, 3)."""
    rays: int
    """Traced."""


def gather(
    see: See, groups: Groups, rays: int, way: Way = evenly, seed: int = 0, guided: Chosen | None = None
) -> Gathered:
    """Return irradiance from ``rays`` rays a point.

    ``guided`` (P,): points whose rays go ``way``, those of the others evenly. All do without.
    """
    total = np.zeros((len(groups.points), 3))
    for points, how in passes(len(total), rays, way, guided):
        ray, weight = hemisphere_rays(groups, points, rays, how, seed)
        _, radiance = see(ray)
        total[points] = sums_of_rays([channel * weight for channel in radiance], rays)
    return Gathered(total, rays * len(total))


def passes(count: int, rays: int, way: Way, guided: Chosen | None = None) -> Iterator[tuple[Integers, Way]]:
    """Yield points that gather at once, by number, and how their rays go.

    A pass in which all rays go evenly does not pay for the guidance of others.
    """
    everyone = np.arange(count)
    parts = [(everyone, way)] if guided is None else [(everyone[guided], way), (everyone[~guided], evenly)]
    most = max(1, MOST_RAYS // rays)
    for points, how in parts:
        for first in range(0, len(points), most):
            yield points[first : first + most], how


def hemisphere_rays(groups: Groups, points: Integers, rays: int, way: Way, seed: int) -> tuple[mi.Ray3f, mi.Float]:
    """Return ``rays`` rays of each of some points, by number, and what each stands for of pi."""
    lane, number = divide(dr.arange(mi.UInt32, len(points) * rays), rays)
    point = dr.gather(mi.UInt32, upload(mi.UInt32, points), lane)
    local, weight = way(point, number, dr.opaque(mi.UInt32, rays), seed)
    return groups.leave(point, local), weight


def sums_of_rays(channels: list[Any], rays: int) -> Floats:
    """Return the sums (P, C) of what each ``rays`` rays in turn bring, by channel (mi.Float).

    In double precision: a million like terms added one after the other are off by 3e-4 in single.
    """
    wide = dr.float64_array_t(mi.Float)
    sums = [dr.block_sum(wide(channel), rays) for channel in channels]
    dr.eval(sums)
    return np.stack([channel.numpy() for channel in sums], axis=-1)
