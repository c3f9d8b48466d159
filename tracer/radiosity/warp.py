"""Rays of hemispheres as one lattice, drawn closer together where they deserve to be.

Strata tear the lattice of a hemisphere into small ones, and what its evenness was worth is lost. Here the lattice of
the unit square is warped before it is laid over the hemisphere: the square is cut into B x B cells, each with the
density that the triangles behind it deserve, rows are stretched by their sums and the cells of a row by theirs. A ray
stands for pi / N over its cell's density. Where all deserve the same the warp does nothing, and nothing is lost.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.core.sphere import normalised
from tracer.radiosity.guide import Guide
from tracer.radiosity.lattice import Way, evenly, lattice
from tracer.radiosity.triangle_hierarchy import pyramid

Integers = NDArray[np.int64]
WITHIN = 8
"""Places along each side of a cell where the triangle behind it is asked for."""


class Warp:
    """Directions as a guide says (``lattice.Way``)."""

    def __init__(self, guide: Guide) -> None:
        depth = guide.regions.pyramid.depth
        self.strips = 4 << depth
        density = densities(guide)[:, behind(depth, self.strips)].mean(axis=(2, 4))
        rows, columns = knots(density)
        self.groups = guide.groups
        # Everything is on the device before a pass is recorded.
        dr.eval(self.groups.rows)
        # Widths are not left to differences of single precision.
        self.rows, self.columns = (
            upload(mi.Float, np.stack([each[..., :-1], np.diff(each)], axis=-1)) for each in (rows, columns)
        )

    def __call__(self, point: Any, number: Any, rays: Any, seed: int) -> tuple[Any, Any]:
        """Return directions and what each stands for."""
        _, u, v = lattice(point, number, rays, seed)
        place, density = self.warp(self.groups.group(point), u, v)
        return mi.warp.square_to_cosine_hemisphere(place), dr.pi / (mi.Float(rays) * density)

    def warp(self, group: Any, u: Any, v: Any) -> tuple[Any, Any]:
        """Return where places in the unit square go (mi.Point2f) for a group, and the density there (mi.Float)."""
        row, x, across = self.stretch(self.rows, group * self.strips, u)
        _, y, along = self.stretch(self.columns, (group * self.strips + row) * self.strips, v)
        return mi.Point2f(x, y), 1 / (across * along)

    def stretch(self, table: Any, first: Any, value: Any) -> tuple[Any, Any, Any]:
        """Return the strip that a value in [0, 1) lies in, where it goes, and by how much it is stretched there."""
        value = value * self.strips
        strip = dr.minimum(mi.UInt32(value), self.strips - 1)
        begin, width = dr.gather(mi.Array2f, table, first + strip)
        place = dr.fma(width, value - mi.Float(strip), begin)
        return strip, dr.minimum(place, 1 - dr.epsilon(mi.Float)), width * self.strips

    def density_of(self, group: Any, local: Any) -> Any:
        """Return the density (mi.Float) of directions (mi.Vector3f), z the normal, over that of the cosine."""
        place = mi.warp.cosine_hemisphere_to_square(local)
        row, across = self.find(self.rows, group * self.strips, place.x)
        _, along = self.find(self.columns, (group * self.strips + row) * self.strips, place.y)
        return 1 / (across * along)

    def find(self, table: Any, first: Any, place: Any) -> tuple[Any, Any]:
        """Return the strip that goes to a place in [0, 1), and by how much it is stretched."""
        strip = dr.zeros(mi.UInt32, dr.width(place))
        step = self.strips >> 1
        while step:
            strip = dr.select(dr.gather(mi.Float, table, 2 * (first + strip + step)) <= place, strip + step, strip)
            step >>= 1
        return strip, dr.gather(mi.Array2f, table, first + strip).y * self.strips


def warped(guide: Guide) -> Way:
    """Return directions as a guide says, evenly spread ones if it says nothing."""
    return Warp(guide) if len(guide.share) else evenly


def knots(density: Floats) -> tuple[Floats, Floats]:
    """Return where the edges of equal strips of the unit square go: of rows (G, B + 1), and in each (G, B, B + 1).

    ``density`` (G, B, B) is that of cells of the square.
    """
    groups, cells, _ = density.shape
    rows = inverse(density.sum(axis=2))
    sums = np.concatenate([np.zeros((groups, 1, cells)), np.cumsum(density, axis=1)], axis=1)
    place = rows * cells
    cell = np.minimum(place.astype(np.int64), cells - 1)
    part = (place - cell)[..., None]
    before, after = (np.take_along_axis(sums, each[..., None], axis=1) for each in (cell, cell + 1))
    until = before + part * (after - before)
    return rows, inverse(np.maximum(np.diff(until, axis=1), 0))


def inverse(density: Floats) -> Floats:
    """Return the places (..., B + 1) in [0, 1] up to which shares 0, 1 / B, ... 1 of a density (..., B) lie."""
    cells = density.shape[-1]
    total = density.sum(axis=-1, keepdims=True)
    density = np.where(total > 0, density, 1)
    sums = np.cumsum(density, axis=-1)
    sums = np.concatenate([np.zeros_like(sums[..., :1]), sums], axis=-1) / sums[..., -1:]
    share = np.linspace(0, 1, cells + 1)
    cell = np.zeros(sums.shape, np.int64)
    for k in range(1, cells):
        cell += sums[..., k, None] <= share
    begin, end = (np.take_along_axis(sums, each, axis=-1) for each in (cell, cell + 1))
    found = (cell + np.clip((share - begin) / np.maximum(end - begin, 1e-300), 0, 1)) / cells
    found[..., 0], found[..., -1] = 0, 1
    return found


def densities(guide: Guide) -> Floats:
    """Return the density (G, T) of all triangles of the deepest level, 1 if spread evenly."""
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
    u, v = (upload(mi.Float, each) for each in np.meshgrid(middle, middle, indexing="ij"))
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
