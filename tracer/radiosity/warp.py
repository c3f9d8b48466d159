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

from tracer.radiosity.guide import Guide
from tracer.radiosity.lattice import lattice
from tracer.radiosity.pyramid import pyramid
from tracer.viewpoint.sphere import normalised

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
WITHIN = 8
"""Places along each side of a cell where the triangle behind it is asked for."""


class Warp:
    """Directions as a guide says (``lattice.Way``)."""

    def __init__(self, guide: Guide) -> None:
        depth = guide.regions.pyramid.depth
        self.cells = 4 << depth
        density = densities(guide)[:, behind(depth, self.cells)].mean(axis=(2, 4))
        density /= density.mean(axis=(1, 2), keepdims=True)
        rows = np.cumsum(density.mean(axis=2), axis=1) / self.cells
        columns = np.cumsum(density, axis=2) / density.sum(axis=2, keepdims=True)
        rows[:, -1], columns[:, :, -1] = 1, 1
        self.groups = guide.groups
        # Everything is on the device before a pass is recorded.
        dr.eval(self.groups.rows)
        self.density, self.rows, self.columns = (
            mi.Float(each.astype(np.float32).ravel()) for each in (density, rows, columns)
        )

    def __call__(self, point: Any, number: Any, rays: Any, seed: int) -> tuple[Any, Any]:
        """Return directions and what each stands for."""
        _, u, v = lattice(point, number, rays, seed)
        place, density = self.warp(self.groups.group(point), u, v)
        return mi.warp.square_to_cosine_hemisphere(place), dr.pi / (mi.Float(rays) * density)

    def warp(self, group: Any, u: Any, v: Any) -> tuple[Any, Any]:
        """Return where places in the unit square go (mi.Point2f) for a group, and the density there (mi.Float)."""
        row, u = self.find(self.rows, group * self.cells, u)
        first = (group * self.cells + row) * self.cells
        column, v = self.find(self.columns, first, v)
        density = dr.gather(mi.Float, self.density, first + column)
        return mi.Point2f((mi.Float(row) + u) / self.cells, (mi.Float(column) + v) / self.cells), density

    def density_of(self, group: Any, local: Any) -> Any:
        """Return the density (mi.Float) of directions (mi.Vector3f), z the normal, over that of the cosine."""
        place = mi.warp.cosine_hemisphere_to_square(local)
        row, column = (dr.clip(mi.Int32(each * self.cells), 0, self.cells - 1) for each in (place.x, place.y))
        return dr.gather(mi.Float, self.density, (group * self.cells + mi.UInt32(row)) * self.cells + mi.UInt32(column))

    def find(self, sums: Any, first: Any, value: Any) -> tuple[Any, Any]:
        """Return which of the cells that begin at ``first`` a value in [0, 1) falls into, and where in it."""
        cell = dr.zeros(mi.UInt32, dr.width(value))
        step = self.cells >> 1
        while step:
            cell = dr.select(dr.gather(mi.Float, sums, first + cell + (step - 1)) <= value, cell + step, cell)
            step >>= 1
        begin = dr.gather(mi.Float, sums, first + cell - 1, cell > 0)
        end = dr.gather(mi.Float, sums, first + cell)
        return cell, dr.clip((value - begin) / dr.maximum(end - begin, 1e-12), 0, 1 - dr.epsilon(mi.Float))


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
    u, v = (mi.Float(each.ravel()) for each in np.meshgrid(middle, middle, indexing="ij"))
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
