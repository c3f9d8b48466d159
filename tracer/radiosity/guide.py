"""What a group of points knows before it gathers: which triangles of its hemisphere deserve how many of its rays.

A triangle T deserves rays as its projected solid angle Omega'_T times its complexity C_T, mixed with a floor that goes
as the cosine does. Complexity says where radiance may vary, not that it does: a group whose rays that looked saw too
little vary for the guide to gain has its rays spread evenly, as if there were no guide.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.radiosity.groups import Groups
from tracer.radiosity.hemisphere import HALVES, WHOLE, Division, Kind, Regions, See, subdivide

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
    def guided(self) -> NDArray[np.bool_]:
        """Whether each point (P,) is in a group with triangles."""
        found: NDArray[np.bool_] = (np.diff(self.first) > 0)[self.groups.group_of]
        return found


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
    worth: float = 1.15
    """A group whose expected gain is less is not guided, nor looked at further."""
    overall: float = 1.1
    """If a sample of groups is not sure to gain as much on average, none is guided."""


FEWEST, MANY = 64, 1024
"""Rays that look through a triangle."""
SAMPLE = 16
"""Groups that look first, at least; fewer than twice as many."""


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
    """Return the guide of groups, after a look: a sample of them looks first."""
    count, sizes = len(groups), np.diff(groups.first)

    def worth(regions: Regions) -> NDArray[np.bool_]:
        return gain(regions, count, guidance.floor) >= guidance.worth

    large = np.flatnonzero(2 * sizes >= guidance.members)
    sampled = np.arange(len(large)) % max(len(large) // SAMPLE, 1) == 0
    regions = subdivide(see, groups, division, surfaces, seed, large[sampled], worth)
    kept = np.zeros(count, bool)
    if sure_gain(regions, sizes, guidance.floor) >= guidance.overall:
        others = subdivide(see, groups, division, surfaces, seed + 1, large[~sampled], worth)
        regions = regions.together(others)
        kept = worth(regions)
    some = kept[regions.group]
    counts = np.bincount(regions.group[some], minlength=count)
    share = shares(regions, count, guidance.floor)[some]
    return Guide(groups, regions.where(some), np.concatenate([[0], np.cumsum(counts)]), share)


def sure_gain(regions: Regions, sizes: Integers, floor: float) -> float:
    """Return the mean gain of groups that looked, less one standard error; ``sizes`` (G,): points of all groups.

    It is a mean of logarithms, each by the error that the group's points are expected to have: no single group that
    chance made bright decides for all.
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
    """Return the share (R,) of a group's rays that each triangle deserves; they add up to 1 in each group.

    ``seen``: by which of the rays that looked.
    """
    even = regions.pyramid.projected[regions.triangle] / np.pi
    complexity = even * np.maximum(regions.complexity[:, seen], 0)
    of_group = np.bincount(regions.group, complexity, groups)[regions.group]
    return floor * even + (1 - floor) * np.divide(complexity, of_group, out=even.copy(), where=of_group > 0)


def gain(regions: Regions, groups: int, floor: float) -> Floats:
    """Return the variance (G,) that even rays are expected to have over that of guided ones; 1 if none is seen."""
    even, guided = variances(regions, groups, floor)
    return np.divide(even, guided, out=np.ones(groups), where=guided > 0)


def variances(regions: Regions, groups: int, floor: float) -> tuple[Floats, Floats]:
    """Return the variance (G,) that even rays of a group are expected to have, and guided ones, in the same unit.

    The lattice of a triangle errs where edges cross its cells: sum_T Omega'_T sigma_T^2 / density_T^1.5. Shares by one
    half of the rays that looked are judged by the other, or a few lights hit by chance would seem worth a guide.
    """
    projected = regions.pyramid.projected[regions.triangle]
    even, guided = np.zeros(groups), np.zeros(groups)
    for own, other in (HALVES, HALVES[::-1]):
        density = shares(regions, groups, floor, own) * np.pi / projected
        variance = projected * np.square(regions.deviation[:, other])
        even += np.bincount(regions.group, variance, groups)
        guided += np.bincount(regions.group, variance / density**1.5, groups)
    return even, guided
