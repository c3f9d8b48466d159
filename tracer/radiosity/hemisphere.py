"""Divide the hemispheres of groups of points where what they see is complex (the paper, section 4.2.2).

Every hemisphere begins as four spherical triangles. Each is looked through with a few rays; one that sees something
more complex than a threshold is split in four, as long as a depth is not reached. (The paper says "or", with which all
are split as deep as that.) All go in one wavefront, level after level.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, get_args

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.device import divide, multiplicity, to_unit, upload
from tracer.core.hashing import GOLDEN_RATIO, mix
from tracer.radiosity.cosine_triangle import cosine_in_triangle, table_of
from tracer.radiosity.groups import Groups
from tracer.radiosity.lattice import spread
from tracer.radiosity.triangle_hierarchy import Pyramid, pyramid

Integers = NDArray[np.int64]
MOST_RAYS = 1 << 22
"""In one wavefront."""
Kind = Literal["entropy", "gini", "distinct", "viewpoint_complexity", "deviation"]
KINDS: tuple[str, ...] = get_args(Kind)
See = Callable[[Any], tuple[Any, Any]]
"""From rays (mi.Ray3f) to what each hits: its ID (mi.UInt32, ``NOTHING`` if it misses) and radiance (mi.Color3f)."""
NOTHING = 0xFFFFFFFF
WHOLE, HALVES = 0, (1, 2)
"""Columns of what all rays saw that looked through a triangle, and of what each half of them did."""
UNSEEN = 0.5
"""Of the mean radiance of a triangle: deviation that is taken for granted."""


@dataclass(frozen=True)
class Division:
    """How to divide hemispheres."""

    kind: Kind = "entropy"
    """Complexity: bits or Gini index of the IDs seen, how many there are, C(V); or the deviation of radiance, in units
    of what the group sees on average, which is not complexity but what complexity stands for."""
    threshold: float = 0.3
    """A triangle that is more complex is split."""
    depth: int = 2
    """Times that a triangle is split at most."""
    rays: int = 8
    """With which a triangle is looked through."""
    widest: float = 1.0
    """Share of a group's triangles of a level that are split at most: those that deserve most rays."""


@dataclass(frozen=True)
class Regions:
    """Spherical triangles that divide the hemispheres of groups, group after group. Arrays (R, ...)."""

    pyramid: Pyramid
    group: Integers
    triangle: Integers
    """Number in the pyramid."""
    complexity: Floats
    """(R, 3): as all rays that looked have it, and each half of them."""
    mean: Floats
    """(R, 3): radiance that they saw, as luminance."""
    deviation: Floats
    """(R, 3): its standard deviation."""
    rays: int
    """That looked, in all triangles, those that were split too."""

    def together(self, others: Regions) -> Regions:
        """Return these regions and those of other groups."""
        both = [np.concatenate(pair) for pair in zip(self.columns, others.columns, strict=True)]
        return regions_of(self.pyramid, both, self.rays + others.rays)

    def where(self, kept: NDArray[np.bool_]) -> Regions:
        """Return some of the regions."""
        return regions_of(self.pyramid, [column[kept] for column in self.columns], self.rays)

    @property
    def columns(self) -> Columns:
        """Everything by region."""
        return [self.group, self.triangle, self.complexity, self.mean, self.deviation]


Columns = list[NDArray[Any]]
Hopeful = Callable[[Regions], NDArray[np.bool_]]
"""From the regions so far to whether each group (G,) is worth more looks."""


def subdivide(
    see: See,
    groups: Groups,
    division: Division,
    surfaces: int = 1,
    seed: int = 0,
    chosen: Integers | None = None,
    hopeful: Hopeful | None = None,
) -> Regions:
    """Return the divided hemispheres of groups: all, or those ``chosen`` by number.

    ``surfaces``: how many IDs there are, for C(V). ``hopeful``: asked after each level but the first; only triangles of
    groups that are, are split further.
    """
    table = pyramid(division.depth)
    parts = table_of(division.depth)
    chosen = np.arange(len(groups)) if chosen is None else chosen
    group, triangle = np.repeat(chosen, 4), np.tile(np.arange(4), len(chosen))
    brightness: Floats = np.ones(len(groups))
    leaves: list[Columns] = []
    rays = 0
    for level in range(division.depth + 1):
        complexity, mean, deviation = look(see, groups, parts, group, triangle, division, surfaces, seed + 7919 * level)
        rays += division.rays * len(group)
        projected = table.projected[triangle]
        if level == 0:
            brightness = np.bincount(group, projected * mean[:, WHOLE] / np.pi, len(groups)).astype(np.float64)
        if division.kind == "deviation":
            # What few rays see vary too little may vary all the same, the more the brighter it is.
            complexity = np.hypot(deviation, UNSEEN * mean) / np.maximum(brightness[group, None], 1e-30)
        found: Columns = [group, triangle, complexity, mean, deviation]
        split = (complexity[:, WHOLE] > division.threshold) & (level < division.depth)
        if hopeful is not None and 0 < level < division.depth:
            split &= hopeful(regions_of(table, joined([*leaves, found]), rays))[group]
        split &= foremost(group, projected * complexity[:, WHOLE], division.widest, len(groups))
        leaves.append([column[~split] for column in found])
        group, triangle = np.repeat(group[split], 4), table.children(triangle[split], level).ravel()
        if not len(group):
            break
    return regions_of(table, joined(leaves), rays)


def regions_of(table: Pyramid, columns: Columns, rays: int) -> Regions:
    """Return the regions, group after group, of columns in any order."""
    order = np.argsort(columns[0], kind="stable")
    group, triangle, complexity, mean, deviation = (column[order] for column in columns)
    return Regions(table, group, triangle, complexity, mean, deviation, rays)


def joined(leaves: list[Columns]) -> Columns:
    """Return the columns of several levels as one."""
    return [np.concatenate(column) for column in zip(*leaves, strict=True)]


def foremost(group: Integers, value: Floats, share: float, groups: int) -> Any:
    """Return whether each value (R,) is among the largest of its group, a share of them."""
    order = np.lexsort((-value, group))
    count = np.bincount(group, minlength=groups)
    rank = np.empty(len(group), np.int64)
    rank[order] = np.arange(len(group)) - np.repeat(np.cumsum(count) - count, count)
    return rank < np.ceil(share * count[group])


def look(
    see: See,
    groups: Groups,
    parts: Any,
    group: Integers,
    triangle: Integers,
    division: Division,
    surfaces: int,
    seed: int,
) -> tuple[Floats, Floats, Floats]:
    """Return complexity, mean and deviation of luminance (R, 3) of triangles of groups, both given by number (R,).

    ``parts``: ``projected.table_of`` the triangles. The rays of a region are a Fibonacci lattice, shifted at random;
    every other one is of one half. Complexity by IDs is that of all rays.
    """
    count = division.rays
    most = max(1, MOST_RAYS // count)
    found: list[tuple[Floats, ...]] = []
    for first in range(0, len(group), most):
        some = slice(first, first + most)
        region, number = divide(dr.arange(mi.UInt32, len(group[some]) * count), count)
        of, which = (dr.gather(mi.UInt32, upload(mi.UInt32, each[some]), region) for each in (group, triangle))
        key = mix(region ^ mix(dr.opaque(mi.UInt32, (seed + first + 0x68E31DA4) & NOTHING)))
        u = spread(number, dr.opaque(mi.UInt32, count), key)
        v = to_unit(number * GOLDEN_RATIO + mix(key))
        point = groups.member(of, mix(key) ^ mix(number))
        identity, radiance = see(groups.leave(point, cosine_in_triangle(parts, which, u, v)))
        dr.eval(identity, radiance)
        grey = mi.luminance(radiance)
        other = dr.select((number & 1) == 1, grey, 0)
        sums = [dr.block_sum(each, count) for each in (grey, dr.square(grey), other, dr.square(other))]
        value = mi.Float(0)
        if division.kind != "deviation":
            # Every ray is compared with all others of its region: dear.
            same = mi.Float(multiplicity(identity, count))
            value = complexity_of(division.kind, same, identity != NOTHING, count, surfaces)
        dr.eval(value, sums)
        mean, deviation = halved(np.stack([one.numpy().astype(np.float64) for one in sums], axis=-1), count)
        complexity = deviation if division.kind == "deviation" else np.tile(value.numpy()[:, None], (1, 3))
        found.append((complexity.astype(np.float64), mean, deviation))
    if not found:
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3))
    complexity, mean, deviation = (np.concatenate(column) for column in zip(*found, strict=True))
    return complexity, mean, deviation


def halved(sums: Floats, count: int) -> tuple[Floats, Floats]:
    """Return means and deviations (R, 3) of ``count`` rays and of their halves.

    ``sums`` (R, 4): sum and sum of squares of all, and of every other one.
    """
    total, squares = (
        np.stack([whole, whole - part, part], axis=-1) for whole, part in ((sums[:, k], sums[:, k + 2]) for k in (0, 1))
    )
    rays = np.maximum([count, count - count // 2, count // 2], 1)
    mean = total / rays
    return mean, np.sqrt(np.maximum(squares / rays - np.square(mean), 0))


def complexity_of(kind: Kind, same: Any, hit: Any, count: int, surfaces: int) -> Any:
    """Return the complexity (mi.Float) of each group of ``count`` rays; ``same``: how many of it hit what each hit."""
    if kind == "entropy":
        return -dr.block_sum(dr.log2(same / count), count) / count
    if kind == "gini":
        return 1 - dr.block_sum(same, count) / count**2
    if kind == "distinct":
        return dr.block_sum(1 / same, count)
    visible = dr.block_sum(dr.select(hit, 1 / same, 0), count)
    return visible / surfaces + dr.block_sum(dr.select(hit, mi.Float(1), 0), count) / count
