"""Divide the hemispheres of groups of points where the view is complex (the paper, section 4.2.2).

Every hemisphere begins as four spherical triangles. A few rays look through each triangle. A triangle whose view is
more complex than a threshold is split in four, as long as the largest depth is not reached. (The paper says "or" in
place of "and", by which all triangles would be split to that depth.) The triangles of a level go in one wavefront.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, get_args

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.core.device import divide, multiplicity, to_unit, upload
from tracer.core.hashing import GOLDEN_RATIO, mix
from tracer.radiosity.cosine_triangle import cosine_in_triangle, table_of
from tracer.radiosity.groups import Groups
from tracer.radiosity.lattice import spread
from tracer.radiosity.triangle_hierarchy import Pyramid, pyramid

MOST_RAYS = 1 << 22
"""Largest number of rays in one wavefront."""
Kind = Literal["entropy", "gini", "distinct", "viewpoint_complexity", "deviation"]
"""Kinds of complexity, see ``Division.kind``."""
KINDS: tuple[str, ...] = get_args(Kind)
"""All kinds of complexity."""
See = Callable[[Any], tuple[Any, Any]]
"""From rays (mi.Ray3f) to the ID (mi.UInt32, ``NOTHING`` for a miss) and the radiance (mi.Color3f) of what they hit."""
NOTHING = 0xFFFFFFFF
"""ID that stands for a miss."""
WHOLE, HALVES = 0, (1, 2)
"""Columns of statistics of the rays that looked through a triangle: of all of them, and of each half of them."""
UNSEEN = 0.5
"""Standard deviation that is assumed in any case, as a share of the mean radiance of a triangle."""


@dataclass(frozen=True)
class Division:
    """How to divide hemispheres."""

    kind: Kind = "entropy"
    """Kind of complexity: the entropy in bits, the Gini index or the number of the IDs seen, or C(V); or the standard
    deviation of radiance, in units of the mean radiance that the group sees. The deviation is not itself a complexity,
    but the quantity that complexity stands for."""
    threshold: float = 0.3
    """Complexity above which a triangle is split."""
    depth: int = 2
    """Largest number of times that a triangle is split."""
    rays: int = 8
    """Number of rays that look through a triangle."""
    widest: float = 1.0
    """Largest share of the triangles of a level of a group that are split; they are those that deserve most rays."""


@dataclass(frozen=True)
class Regions:
    """R spherical triangles that divide the hemispheres of groups, group after group.

    The columns of ``complexity``, ``mean`` and ``deviation`` are those of all rays that looked, and of each half of
    them, see ``WHOLE`` and ``HALVES``.
    """

    pyramid: Pyramid
    group: Integers
    """(R,): number of the group."""
    triangle: Integers
    """(R,): number of the triangle in the pyramid."""
    complexity: Floats
    """(R, 3): complexity of what the rays saw."""
    mean: Floats
    """(R, 3): mean luminance that the rays saw."""
    deviation: Floats
    """(R, 3): standard deviation of the luminance."""
    rays: int
    """Number of rays that looked in all, including those through triangles that were split."""

    def together(self, other_regions: Regions) -> Regions:
        """Return these regions together with the regions of other groups."""
        columns = [np.concatenate(pair) for pair in zip(self.columns, other_regions.columns, strict=True)]
        return regions_of(self.pyramid, columns, self.rays + other_regions.rays)

    def where(self, selected: NDArray[np.bool_]) -> Regions:
        """Return the regions for which ``selected`` (R,) is true."""
        return regions_of(self.pyramid, [column[selected] for column in self.columns], self.rays)

    @property
    def columns(self) -> Columns:
        """All arrays that have an entry for each region."""
        return [self.group, self.triangle, self.complexity, self.mean, self.deviation]


Columns = list[NDArray[Any]]
"""Arrays with an entry for each region, in the order of ``Regions.columns``."""
Hopeful = Callable[[Regions], NDArray[np.bool_]]
"""From the regions so far to whether each group (G,) is worth another look."""


def subdivide(
    see: See,
    groups: Groups,
    division: Division,
    surfaces: int = 1,
    seed: int = 0,
    chosen: Integers | None = None,
    hopeful: Hopeful | None = None,
) -> Regions:
    """Return the divided hemispheres of all groups, or of the groups ``chosen`` by number.

    ``surfaces``: number of all IDs, for C(V). ``hopeful`` is called after each level but the first and the last; only
    triangles of groups for which it returns true are split further.
    """
    hierarchy = pyramid(division.depth)
    triangle_table = table_of(division.depth)
    chosen = np.arange(len(groups)) if chosen is None else chosen
    group, triangle = np.repeat(chosen, 4), np.tile(np.arange(4), len(chosen))
    brightness: Floats = np.ones(len(groups))
    leaves: list[Columns] = []
    rays = 0
    for level in range(division.depth + 1):
        complexity, mean, deviation = look(
            see, groups, triangle_table, group, triangle, division, surfaces, seed + 7919 * level
        )
        rays += division.rays * len(group)
        projected = hierarchy.projected[triangle]
        if level == 0:
            brightness = np.bincount(group, projected * mean[:, WHOLE] / np.pi, len(groups)).astype(np.float64)
        if division.kind == "deviation":
            # Few rays may miss how much radiance varies, and bright triangles may vary most: assume some deviation.
            complexity = np.hypot(deviation, UNSEEN * mean) / np.maximum(brightness[group, None], 1e-30)
        regions_of_level: Columns = [group, triangle, complexity, mean, deviation]
        split = (complexity[:, WHOLE] > division.threshold) & (level < division.depth)
        if hopeful is not None and 0 < level < division.depth:
            split &= hopeful(regions_of(hierarchy, joined([*leaves, regions_of_level]), rays))[group]
        split &= foremost(group, projected * complexity[:, WHOLE], division.widest, len(groups))
        leaves.append([column[~split] for column in regions_of_level])
        group, triangle = np.repeat(group[split], 4), hierarchy.children(triangle[split], level).ravel()
        if not len(group):
            break
    return regions_of(hierarchy, joined(leaves), rays)


def regions_of(table: Pyramid, columns: Columns, rays: int) -> Regions:
    """Return the regions, group after group, of columns in any order."""
    order = np.argsort(columns[0], kind="stable")
    group, triangle, complexity, mean, deviation = (column[order] for column in columns)
    return Regions(table, group, triangle, complexity, mean, deviation, rays)


def joined(levels: list[Columns]) -> Columns:
    """Return the columns of all levels, level after level."""
    return [np.concatenate(columns) for columns in zip(*levels, strict=True)]


def foremost(group: Integers, value: Floats, share: float, groups: int) -> Any:
    """Return whether each value (R,) is among the given share of largest values of its group."""
    order = np.lexsort((-value, group))
    count = np.bincount(group, minlength=groups)
    rank = np.empty(len(group), np.int64)
    rank[order] = np.arange(len(group)) - np.repeat(np.cumsum(count) - count, count)
    return rank < np.ceil(share * count[group])


def look(
    see: See,
    groups: Groups,
    triangle_table: Any,
    group: Integers,
    triangle: Integers,
    division: Division,
    surfaces: int,
    seed: int,
) -> tuple[Floats, Floats, Floats]:
    """Return complexity, mean and standard deviation of luminance (R, 3) of triangles of groups.

    ``group`` and ``triangle`` (R,) are numbers; ``triangle_table`` is ``cosine_triangle.table_of`` the triangles. The
    rays of a region form a Fibonacci lattice, shifted at random; rays of even and of odd number are its two halves.
    Complexity by IDs is that of all rays, in each column.
    """
    count = division.rays
    regions_per_pass = max(1, MOST_RAYS // count)
    results: list[tuple[Floats, ...]] = []
    for first in range(0, len(group), regions_per_pass):
        chunk = slice(first, first + regions_per_pass)
        region, ray_index = divide(dr.arange(mi.UInt32, len(group[chunk]) * count), count)
        group_of_ray, triangle_of_ray = (
            dr.gather(mi.UInt32, upload(mi.UInt32, numbers[chunk]), region) for numbers in (group, triangle)
        )
        key = mix(region ^ mix(dr.opaque(mi.UInt32, (seed + first + 0x68E31DA4) & NOTHING)))
        u = spread(ray_index, dr.opaque(mi.UInt32, count), key)
        v = to_unit(ray_index * GOLDEN_RATIO + mix(key))
        point = groups.member(group_of_ray, mix(key) ^ mix(ray_index))
        identity, radiance = see(groups.leave(point, cosine_in_triangle(triangle_table, triangle_of_ray, u, v)))
        dr.eval(identity, radiance)
        grey = mi.luminance(radiance)
        odd_half = dr.select((ray_index & 1) == 1, grey, 0)
        sums = [dr.block_sum(values, count) for values in (grey, dr.square(grey), odd_half, dr.square(odd_half))]
        value = mi.Float(0)
        if division.kind != "deviation":
            # This is expensive: every ray is compared with all other rays of its region.
            same = mi.Float(multiplicity(identity, count))
            value = complexity_of(division.kind, same, identity != NOTHING, count, surfaces)
        dr.eval(value, sums)
        mean, deviation = halved(np.stack([total.numpy().astype(np.float64) for total in sums], axis=-1), count)
        complexity = deviation if division.kind == "deviation" else np.tile(value.numpy()[:, None], (1, 3))
        results.append((complexity.astype(np.float64), mean, deviation))
    if not results:
        return np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3))
    complexity, mean, deviation = (np.concatenate(column) for column in zip(*results, strict=True))
    return complexity, mean, deviation


def halved(sums: Floats, count: int) -> tuple[Floats, Floats]:
    """Return means and standard deviations (R, 3) of ``count`` rays and of each half of them.

    ``sums`` (R, 4): sum and sum of squares over all rays, then over the rays of odd number.
    """
    total, squares = (
        np.stack([all_rays, all_rays - odd_half, odd_half], axis=-1)
        for all_rays, odd_half in ((sums[:, k], sums[:, k + 2]) for k in (0, 1))
    )
    rays = np.maximum([count, count - count // 2, count // 2], 1)
    mean = total / rays
    return mean, np.sqrt(np.maximum(squares / rays - np.square(mean), 0))


def complexity_of(kind: Kind, same: Any, hit: Any, count: int, surfaces: int) -> Any:
    """Return the complexity (mi.Float) of each region, of ``count`` rays.

    ``same``: number of rays of the region, for each ray, that saw the same ID as the ray. ``surfaces``: number of IDs.
    """
    if kind == "entropy":
        return -dr.block_sum(dr.log2(same / count), count) / count
    if kind == "gini":
        return 1 - dr.block_sum(same, count) / count**2
    if kind == "distinct":
        return dr.block_sum(1 / same, count)
    visible = dr.block_sum(dr.select(hit, 1 / same, 0), count)
    return visible / surfaces + dr.block_sum(dr.select(hit, mi.Float(1), 0), count) / count
