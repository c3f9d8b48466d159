"""What a group of points knows before it gathers: which triangles of its hemisphere deserve how many of its rays.

A triangle T deserves rays as its projected solid angle Omega'_T times its complexity C_T, mixed with a floor that goes
as the cosine does. Complexity says where radiance may vary, not that it does: a group whose rays that looked saw too
little vary for the guide to gain has its rays spread evenly, as if there were no guide.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracer.radiosity.groups import Groups
from tracer.radiosity.hemisphere import Division, Kind, Regions, See, subdivide

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Guide:
    """Triangles of groups and how many rays they deserve. Groups without triangles have rays spread evenly."""

    groups: Groups
    regions: Regions
    first: Integers
    """(G + 1,): where the triangles of each group begin, and their number."""
    share: Floats
    """(R,): of the rays of its group that each triangle deserves."""

    @property
    def guided(self) -> float:
        """Share of the points that are in a group with triangles."""
        sizes = np.diff(self.groups.first)
        return float(sizes[np.diff(self.first) > 0].sum() / max(sizes.sum(), 1))


@dataclass(frozen=True)
class Guidance:
    """How rays are guided."""

    kind: Kind = "deviation"
    threshold: float = 0.6
    depth: int = 2
    members: int = 256
    """Points of a group at most; groups of less than half are not worth a look."""
    look: float = 1 / 16
    """Share of the rays that looks, in a full group; twice as much in the smallest."""
    floor: float = 0.5
    """Share of the other rays that goes as the cosine does."""
    worth: float = 1.05
    """A group whose expected gain is less is not guided."""


FEWEST, MANY = 64, 1024
"""Rays that look through a triangle."""


def division_for(guidance: Guidance, rays: int) -> Division | None:
    """Return how groups whose points have ``rays`` rays each divide their hemispheres; None if they cannot afford it.

    Half of the triangles of a level are split at most, so 4 (2^(depth + 1) - 1) are looked through.
    """
    budget = guidance.look * rays * guidance.members
    for depth in range(guidance.depth, -1, -1):
        each = int(budget / (4 * (2 ** (depth + 1) - 1)))
        if each >= FEWEST:
            several = min(2 ** int(np.log2(each)), MANY)
            return Division(guidance.kind, guidance.threshold, depth, several, 0.5)
    return None


def make_guide(see: See, groups: Groups, division: Division, guidance: Guidance, surfaces: int, seed: int) -> Guide:
    """Return the guide of groups, after a look."""
    regions = subdivide(see, groups, division, surfaces, seed, -(-guidance.members // 2))
    share = shares(regions, len(groups), guidance.floor)
    kept = (gain(regions, len(groups), share) >= guidance.worth)[regions.group]
    counts = np.bincount(regions.group[kept], minlength=len(groups))
    return Guide(groups, regions.where(kept), np.concatenate([[0], np.cumsum(counts)]), share[kept])


def shares(regions: Regions, groups: int, floor: float) -> Floats:
    """Return the share (R,) of a group's rays that each triangle deserves; they add up to 1 in each group."""
    even = regions.pyramid.projected[regions.triangle] / np.pi
    complexity = even * np.maximum(regions.complexity, 0)
    of_group = np.bincount(regions.group, complexity, groups)[regions.group]
    return floor * even + (1 - floor) * np.divide(complexity, of_group, out=even.copy(), where=of_group > 0)


def gain(regions: Regions, groups: int, share: Floats) -> Floats:
    """Return the variance (G,) that even rays are expected to have, divided by that of guided ones.

    Both are sum_T (Omega'_T sigma_T)^2 / n_T. It is 1 where nothing was seen to vary.
    """
    projected = regions.pyramid.projected[regions.triangle]
    variance = np.square(projected * regions.deviation)
    even = np.bincount(regions.group, variance * np.pi / projected, groups)
    guided = np.bincount(regions.group, variance / share, groups)
    return np.divide(even, guided, out=np.ones(groups), where=guided > 0)
