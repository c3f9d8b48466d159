"""Irradiance of points, as the weighted sum of the radiance along rays of each hemisphere.

E(x) is the integral of L cos over the hemisphere. If N rays have q times the density of the cosine, ray j has the
weight w_j = pi / (N q_j), or Omega'_T / n_T in strata, and E = sum_j w_j L_j. The expectation of the sum is E however
the rays are distributed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.core.device import divide, upload
from tracer.radiosity.groups import Groups
from tracer.radiosity.hemisphere import MOST_RAYS, See
from tracer.radiosity.lattice import Way, evenly

Chosen = NDArray[np.bool_]


@dataclass(frozen=True)
class Gathered:
    """Irradiance of points and the number of rays that it took."""

    irradiance: Floats
    """(P, 3): irradiance of each point, by channel."""
    rays: int
    """Number of rays traced."""


def gather(
    see: See, groups: Groups, rays: int, way: Way = evenly, seed: int = 0, guided: Chosen | None = None
) -> Gathered:
    """Return irradiance from ``rays`` rays a point.

    ``guided`` (P,): whether the rays of a point are spread by ``way``; otherwise they are spread evenly. Without
    ``guided``, the rays of all points are spread by ``way``.
    """
    total = np.zeros((len(groups.points), 3))
    for points, point_way in passes(len(total), rays, way, guided):
        ray, weight = hemisphere_rays(groups, points, rays, point_way, seed)
        _, radiance = see(ray)
        total[points] = sums_of_rays([channel * weight for channel in radiance], rays)
    return Gathered(total, rays * len(total))


def passes(count: int, rays: int, way: Way, guided: Chosen | None = None) -> Iterator[tuple[Integers, Way]]:
    """Yield the numbers of the points of each pass, and the way in which their rays are spread.

    Guided and other points have passes of their own, so that evenly spread rays are not slowed down by guidance.
    """
    all_points = np.arange(count)
    parts = [(all_points, way)] if guided is None else [(all_points[guided], way), (all_points[~guided], evenly)]
    points_per_pass = max(1, MOST_RAYS // rays)
    for points, point_way in parts:
        for first in range(0, len(points), points_per_pass):
            yield points[first : first + points_per_pass], point_way


def hemisphere_rays(groups: Groups, points: Integers, rays: int, way: Way, seed: int) -> tuple[mi.Ray3f, mi.Float]:
    """Return ``rays`` rays of each point, given by number, and their weights, which add up to about pi for a point."""
    row, ray_index = divide(dr.arange(mi.UInt32, len(points) * rays), rays)
    point = dr.gather(mi.UInt32, upload(mi.UInt32, points), row)
    local, weight = way(point, ray_index, dr.opaque(mi.UInt32, rays), seed)
    return groups.leave(point, local), weight


def sums_of_rays(channels: list[Any], rays: int) -> Floats:
    """Return the sums (P, C) over every ``rays`` successive entries of each channel (mi.Float).

    They are added in double precision: a million like terms added one after the other are off by 3e-4 in single.
    """
    wide = dr.float64_array_t(mi.Float)
    sums = [dr.block_sum(wide(channel), rays) for channel in channels]
    dr.eval(sums)
    return np.stack([channel.numpy() for channel in sums], axis=-1)
