"""Irradiance of points: rays of each hemisphere, each of which stands for a part of it.

E(x) is the integral of L cos over the hemisphere. Of rays that go as a density q times that of the cosine, j stands for
w_j = pi / (N q_j), and E = sum_j w_j L_j; in strata, for Omega'_T / n_T. Its expectation is E wherever the rays go.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.draw import divide
from tracer.radiosity.groups import Groups
from tracer.radiosity.hemisphere import MOST_RAYS, See
from tracer.radiosity.lattice import Way, evenly

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Gathered:
    """Irradiance and what it took."""

    irradiance: Floats
    """(P, 3)."""
    rays: int
    """Traced."""


def gather(see: See, groups: Groups, rays: int, way: Way = evenly, seed: int = 0) -> Gathered:
    """Return irradiance from ``rays`` rays a point."""
    count = len(groups.points)
    total = np.zeros((count, 3))
    most = max(1, MOST_RAYS // rays)
    for first in range(0, count, most):
        some = min(most, count - first)
        ray, weight = hemisphere_rays(groups, first, some, rays, way, seed)
        _, radiance = see(ray)
        sums = [dr.block_sum(channel * weight, rays) for channel in radiance]
        dr.eval(sums)
        total[first : first + some] = np.stack([one.numpy() for one in sums], axis=-1)
    return Gathered(total, rays * count)


def hemisphere_rays(
    groups: Groups, first: int, count: int, rays: int, way: Way, seed: int
) -> tuple[mi.Ray3f, mi.Float]:
    """Return ``rays`` rays of each of ``count`` points from ``first`` on, and what each stands for of pi."""
    point, number = divide(dr.arange(mi.UInt32, count * rays), rays)
    point += dr.opaque(mi.UInt32, first)
    local, weight = way(point, number, dr.opaque(mi.UInt32, rays), seed)
    return groups.leave(point, local), weight
