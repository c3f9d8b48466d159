"""The guide of a group of points: how many of its rays each triangle of its hemisphere deserves.

The share of rays of a triangle T is in proportion to its projected solid angle Omega'_T times its complexity C_T, mixed
with a floor in proportion to Omega'_T alone. Complexity says where radiance may vary, not that it does. Where the rays
that looked saw too little variation for the guide to gain, the rays of a group are spread evenly, without a guide.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.radiosity.groups import Groups
from tracer.radiosity.hemisphere import HALVES, WHOLE, Division, Kind, Regions, See, subdivide


@dataclass(frozen=True, eq=False)
class Guide:
    """Triangles of groups and how many rays they deserve. Rays of groups without triangles are spread evenly."""

    groups: Groups
    regions: Regions
    first: Integers
    """(G + 1,): where the triangles of each group begin, and as the last entry the number of triangles."""
    share: Floats
    """(R,): share of the rays of its group that each triangle deserves, 0 to 1."""

    @property
    def guided(self) -> NDArray[np.bool_]:
        """Whether each point (P,) is in a group with triangles."""
        is_guided: NDArray[np.bool_] = (np.diff(self.first) > 0)[self.groups.group_of]
        return is_guided


@dataclass(frozen=True)
class Guidance:
    """How rays are guided."""

    kind: Kind = "deviation"
    """Kind of complexity, see ``Division``."""
    threshold: float = 0.6
    """Complexity above which a triangle is split."""
    depth: int = 2
    """Largest number of times that a triangle is split."""
    members: int = 256
    """Largest number of points of a group; groups of less than half of it do not look and are not guided."""
    look: float = 1 / 16
    """Share of the rays that look, in a full group; it is twice as much in the smallest group that looks."""
    floor: float = 0.5
    """Share of the gathering rays that are distributed as the cosine."""
    worth: float = 1.15
    """Smallest expected gain with which a group is guided or looks further."""
    overall: float = 1.1
    """Smallest mean gain, less one standard error, of a sample of groups with which any group is guided."""


FEWEST, MANY = 64, 1024
"""Smallest and largest number of rays that look through one triangle."""
SAMPLE = 16
"""Smallest size of the sample of groups that look first; it is less than twice as large, or all groups if they are
fewer."""


def division_for(guidance: Guidance, rays: int) -> Division | None:
    """Return how groups whose points have ``rays`` rays each divide their hemispheres; None for too few rays.

    At most half of the triangles of a level are split, so at most 4 (2^(depth + 1) - 1) triangles are looked through.
    """
    budget = guidance.look * rays * guidance.members
    for depth in range(guidance.depth, -1, -1):
        rays_per_triangle = int(budget / (4 * (2 ** (depth + 1) - 1)))
        if rays_per_triangle >= FEWEST:
            ray_count = min(2 ** int(np.log2(rays_per_triangle)), MANY)
            return Division(guidance.kind, guidance.threshold, depth, ray_count, 0.5)
    return None


def make_guide(see: See, groups: Groups, division: Division, guidance: Guidance, surfaces: int, seed: int) -> Guide:
    """Return the guide of groups. A sample of the groups looks first; the others look only if the sample gains.

    ``surfaces``: number of IDs that rays may see, see ``subdivide``.
    """
    count, sizes = len(groups), np.diff(groups.first)

    def worth(regions: Regions) -> NDArray[np.bool_]:
        return gain(regions, count, guidance.floor) >= guidance.worth

    large = np.flatnonzero(2 * sizes >= guidance.members)
    sampled = np.arange(len(large)) % max(len(large) // SAMPLE, 1) == 0
    regions = subdivide(see, groups, division, surfaces, seed, large[sampled], worth)
    is_worthwhile = np.zeros(count, bool)
    if sure_gain(regions, sizes, guidance.floor) >= guidance.overall:
        other_regions = subdivide(see, groups, division, surfaces, seed + 1, large[~sampled], worth)
        regions = regions.together(other_regions)
        is_worthwhile = worth(regions)
    is_used = is_worthwhile[regions.group]
    counts = np.bincount(regions.group[is_used], minlength=count)
    share = shares(regions, count, guidance.floor)[is_used]
    return Guide(groups, regions.where(is_used), np.concatenate([[0], np.cumsum(counts)]), share)


def sure_gain(regions: Regions, sizes: Integers, floor: float) -> float:
    """Return the mean gain of groups that looked, less one standard error; ``sizes`` (G,): points of each group.

    It is a mean of logarithms, weighted by the error that the points of each group are expected to have, so that no
    single group that chance made bright decides for all.
    """
    even, guided = variances(regions, len(sizes), floor)
    seen = guided > 0
    if not seen.any():
        return 1.0
    error = (sizes * np.sqrt(even))[seen]
    weight = error / error.sum()
    logarithm = np.log(np.maximum(even[seen] / guided[seen], 1e-9))
    mean = float(weight @ logarithm)
    return float(np.exp(mean - np.linalg.norm(weight * (logarithm - mean))))


def shares(regions: Regions, groups: int, floor: float, seen: int = WHOLE) -> Floats:
    """Return the share (R,) of the rays of its group that each triangle deserves; shares of a group add up to 1.

    ``seen``: column of the complexity to use, ``WHOLE`` or one of ``HALVES`` of the rays that looked.
    """
    even = regions.pyramid.projected[regions.triangle] / np.pi
    complexity = even * np.maximum(regions.complexity[:, seen], 0)
    of_group = np.bincount(regions.group, complexity, groups)[regions.group]
    return floor * even + (1 - floor) * np.divide(complexity, of_group, out=even.copy(), where=of_group > 0)


def gain(regions: Regions, groups: int, floor: float) -> Floats:
    """Return the expected variance of evenly spread rays over that of guided rays (G,); 1 where no variance is seen."""
    even, guided = variances(regions, groups, floor)
    return np.divide(even, guided, out=np.ones(groups), where=guided > 0)


def variances(regions: Regions, groups: int, floor: float) -> tuple[Floats, Floats]:
    """Return the variances (G,) that evenly spread and guided rays of a group are expected to have, in the same unit.

    The lattice of a triangle errs where edges cross its cells: sum_T Omega'_T sigma_T^2 / density_T^1.5. Shares that
    follow from one half of the rays that looked are judged by the other half; otherwise a few lights hit by chance
    would seem worth a guide.
    """
    projected = regions.pyramid.projected[regions.triangle]
    even, guided = np.zeros(groups), np.zeros(groups)
    for seen, judged in (HALVES, HALVES[::-1]):
        density = shares(regions, groups, floor, seen) * np.pi / projected
        variance = projected * np.square(regions.deviation[:, judged])
        even += np.bincount(regions.group, variance, groups)
        guided += np.bincount(regions.group, variance / density**1.5, groups)
    return even, guided
