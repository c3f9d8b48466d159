"""Rays of hemispheres as one lattice, which is denser where the triangles deserve more rays.

Strata tear the lattice of a hemisphere into small ones, which lose the advantage of its evenness. Here the lattice of
the unit square is warped before it is mapped to the hemisphere. The square is cut into B x B cells, each with the
density that the triangles behind it deserve; then rows are stretched by the sum of their densities, and the cells of a
row by their own. The weight of each of N rays is pi / N over the density of its cell. If all triangles deserve the
same, the warp does nothing and the lattice keeps its full advantage.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.core.sphere import normalised
from tracer.radiosity.guide import Guide
from tracer.radiosity.lattice import Way, evenly, lattice
from tracer.radiosity.triangle_hierarchy import pyramid

WITHIN = 8
"""Number of places along each side of a cell at which the triangle behind the cell is looked up."""


class Warp:
    """Directions distributed as a guide says, a ``lattice.Way``."""

    def __init__(self, guide: Guide) -> None:
        depth = guide.regions.pyramid.depth
        self.strips = 4 << depth
        density = densities(guide)[:, behind(depth, self.strips)].mean(axis=(2, 4))
        rows, columns = knots(density)
        self.groups = guide.groups
        # Everything is on the device before a pass is recorded.
        dr.eval(self.groups.rows)
        # Widths are stored as well: differences in single precision would be less exact.
        self.rows, self.columns = (
            upload(mi.Float, np.stack([edges[..., :-1], np.diff(edges)], axis=-1)) for edges in (rows, columns)
        )

    def __call__(self, point: Any, ray_index: Any, rays: Any, seed: int) -> tuple[Any, Any]:
        """Return local directions (mi.Vector3f), z the normal, and their weights (mi.Float), see ``lattice.Way``."""
        _, u, v = lattice(point, ray_index, rays, seed)
        place, density = self.warp(self.groups.group(point), u, v)
        return mi.warp.square_to_cosine_hemisphere(place), dr.pi / (mi.Float(rays) * density)

    def warp(self, group: Any, u: Any, v: Any) -> tuple[Any, Any]:
        """Return where places (u, v) of the unit square are warped to (mi.Point2f), and the density there (mi.Float).

        ``group`` (mi.UInt32): the group whose warp is used. The density is relative to that of the cosine.
        """
        row, x, across = self.stretch(self.rows, group * self.strips, u)
        _, y, along = self.stretch(self.columns, (group * self.strips + row) * self.strips, v)
        return mi.Point2f(x, y), 1 / (across * along)

    def stretch(self, table: Any, first: Any, value: Any) -> tuple[Any, Any, Any]:
        """Return the strip that a value in [0, 1) lies in, where the value is moved to, and the stretch factor there.

        ``first`` (mi.UInt32): the entry of the first strip in the table.
        """
        value = value * self.strips
        strip = dr.minimum(mi.UInt32(value), self.strips - 1)
        begin, width = dr.gather(mi.Array2f, table, first + strip)
        place = dr.fma(width, value - mi.Float(strip), begin)
        return strip, dr.minimum(place, 1 - dr.epsilon(mi.Float)), width * self.strips

    def density_of(self, group: Any, local: Any) -> Any:
        """Return the density (mi.Float) of local directions (mi.Vector3f), relative to the density of the cosine."""
        place = mi.warp.cosine_hemisphere_to_square(local)
        row, across = self.find(self.rows, group * self.strips, place.x)
        _, along = self.find(self.columns, (group * self.strips + row) * self.strips, place.y)
        return 1 / (across * along)

    def find(self, table: Any, first: Any, place: Any) -> tuple[Any, Any]:
        """Return the strip that covers a place in [0, 1) after the warp, and its stretch factor; see ``stretch``."""
        strip = dr.zeros(mi.UInt32, dr.width(place))
        step = self.strips >> 1
        while step:
            strip = dr.select(dr.gather(mi.Float, table, 2 * (first + strip + step)) <= place, strip + step, strip)
            step >>= 1
        return strip, dr.gather(mi.Array2f, table, first + strip).y * self.strips


def warped(guide: Guide) -> Way:
    """Return the way to spread rays as a guide says, or evenly if it guides no group."""
    return Warp(guide) if len(guide.share) else evenly


def knots(density: Floats) -> tuple[Floats, Floats]:
    """Return where the edges of equal strips of the unit square are moved to.

    ``density`` (G, B, B) is that of the cells of the square. Returned are the edges of rows (G, B + 1), and the edges
    of the cells in each row (G, B, B + 1).
    """
    groups, cells, _ = density.shape
    rows = inverse(density.sum(axis=2))
    sums = np.concatenate([np.zeros((groups, 1, cells)), np.cumsum(density, axis=1)], axis=1)
    place = rows * cells
    cell = np.minimum(place.astype(np.int64), cells - 1)
    fraction = (place - cell)[..., None]
    before, after = (np.take_along_axis(sums, index[..., None], axis=1) for index in (cell, cell + 1))
    until = before + fraction * (after - before)
    return rows, inverse(np.maximum(np.diff(until, axis=1), 0))


def inverse(density: Floats) -> Floats:
    """Return the places (..., B + 1) in [0, 1] up to which the shares 0, 1 / B, ... 1 of a density (..., B) lie."""
    cells = density.shape[-1]
    total = density.sum(axis=-1, keepdims=True)
    density = np.where(total > 0, density, 1)
    sums = np.cumsum(density, axis=-1)
    sums = np.concatenate([np.zeros_like(sums[..., :1]), sums], axis=-1) / sums[..., -1:]
    share = np.linspace(0, 1, cells + 1)
    cell = np.zeros(sums.shape, np.int64)
    for k in range(1, cells):
        cell += sums[..., k, None] <= share
    begin, end = (np.take_along_axis(sums, index, axis=-1) for index in (cell, cell + 1))
    places = (cell + np.clip((share - begin) / np.maximum(end - begin, 1e-300), 0, 1)) / cells
    places[..., 0], places[..., -1] = 0, 1
    return places


def densities(guide: Guide) -> Floats:
    """Return the density of rays (G, T) in all triangles of the deepest level; it is 1 for evenly spread rays."""
    regions, table = guide.regions, guide.regions.pyramid
    depth = table.depth
    level = np.searchsorted(table.first, regions.triangle, side="right") - 1
    parts = 4 ** (depth - level)
    begin = (regions.triangle - table.first[level]) * parts
    offset = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    density = np.ones((len(guide.groups), 4 ** (depth + 1)))
    density[np.repeat(regions.group, parts), np.repeat(begin, parts) + offset] = np.repeat(
        guide.share * np.pi / table.projected[regions.triangle], parts
    )
    return density


@cache
def behind(depth: int, cells: int) -> Integers:
    """Return the triangle of the deepest level behind places (cells, WITHIN, cells, WITHIN) of the unit square."""
    table = pyramid(depth)
    middle = (np.arange(cells * WITHIN, dtype=np.float32) + 0.5) / (cells * WITHIN)
    u, v = (upload(mi.Float, coordinate) for coordinate in np.meshgrid(middle, middle, indexing="ij"))
    toward = np.array(mi.warp.square_to_cosine_hemisphere(mi.Point2f(u, v)), np.float64).T
    triangle = np.zeros(len(toward), np.int64)
    candidates = np.tile(np.arange(4), (len(toward), 1))
    for level in range(depth + 1):
        corners = table.corners[candidates]
        planes = normalised(np.cross(corners, np.roll(corners, -1, axis=2)))
        inside = np.einsum("ntek,nk->nte", planes, toward).min(axis=2)
        triangle = candidates[np.arange(len(toward)), inside.argmax(axis=1)]
        if level < depth:
            candidates = table.children(triangle, level)
    return (triangle - table.first[depth]).reshape(cells, WITHIN, cells, WITHIN)
