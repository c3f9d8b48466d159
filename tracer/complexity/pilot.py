"""Pilot rays: primary rays that only ask what they hit. IDs per pixel block, and their complexity.

Two IDs per ray. The *shape* is the pair of instance and shape, so that two instances of one object differ; the *face*
is the primitive within that. A ray that misses has IDs of its own. Meshes are told apart because scenes are opened
without Mitsuba's merging of meshes (see ``tracer.scene.load``); in an ``mi.Scene`` loaded with it, only faces are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.complexity import measures
from tracer.core.arrays import Floats
from tracer.core.device import divide, multiplicity, numbers_hit
from tracer.core.hashing import mix
from tracer.sampling.samples import camera_ray
from tracer.scene.view import View

PILOT_KEY = 0x9170
"""Keeps pilot rays apart from the samples that make the picture, of whatever seed."""
MOST_RAYS = 1 << 22
"""Pilot rays traced at once, unless a row of blocks has more."""


@dataclass(frozen=True)
class Complexity:
    """Complexity of what is seen, per pixel of ``view.grid`` (H, W); all pixels of a block share its values.

    Each measure is computed when it is first asked for.
    """

    grid: tuple[int, int]
    block: int
    """Side of the blocks in pixels."""
    rays: int
    """Pilot rays per pixel."""
    surfaces: int
    """Shapes of the scene."""
    same_shape: NDArray[np.uint32]
    """(rows of blocks, columns, K): for each of the K rays of a block, how many of them hit the shape that it hit."""
    same_face: NDArray[np.uint32]
    """The same for faces."""
    hit: NDArray[np.bool_]
    """(rows of blocks, columns, K): whether the ray hit anything."""
    look_at_geometry: Callable[[], NDArray[np.float32]] = field(repr=False)
    """Traces the same rays once more, see ``measure_geometry``."""

    @cached_property
    def shape_entropy(self) -> Floats:
        """Bits."""
        return self.expand(measures.ray_entropy(self.same_shape))

    @cached_property
    def face_entropy(self) -> Floats:
        """Bits."""
        return self.expand(measures.ray_entropy(self.same_face))

    @cached_property
    def shape_gini(self) -> Floats:
        """0 to 1 - 1 / K."""
        return self.expand(measures.ray_gini(self.same_shape))

    @cached_property
    def face_gini(self) -> Floats:
        """0 to 1 - 1 / K."""
        return self.expand(measures.ray_gini(self.same_face))

    @cached_property
    def distinct(self) -> Floats:
        """How many different shapes the rays of the block hit (a miss is one)."""
        return self.expand(measures.ray_distinct(self.same_shape))

    @cached_property
    def viewpoint(self) -> Floats:
        """C(V) of the paper with shapes as surfaces and the block as image."""
        return self.expand(measures.ray_viewpoint(self.same_shape, self.hit, self.surfaces))

    @cached_property
    def geometry_contrast(self) -> Floats:
        """1 - H / log K of the K numbers of ``measure_geometry``, 0 to 1; the rays are traced when it is asked for.

        Equation 10 of J. Rigau, M. Feixas and M. Sbert, "Entropy-based adaptive sampling", Graphics Interface 2003.
        """
        return self.expand(measures.contrast(self.look_at_geometry()))

    def expand(self, values: Floats) -> Floats:
        """Return values of blocks as values of pixels."""
        if self.block == 1:
            return values
        whole = values.repeat(self.block, axis=0).repeat(self.block, axis=1)
        return whole[: self.grid[0], : self.grid[1]]


def measure_complexity(view: View, sampler: Any, seed: int, rays: int, block: int = 1) -> Complexity:
    """Trace ``rays`` pilot rays per pixel and measure the complexity of blocks of ``block`` x ``block`` pixels.

    Where the image is no multiple of the block, its last pixels are looked at again to fill the blocks at the edge.
    """
    columns = -(-view.grid[1] // block)
    parts = [
        measure_rows(view, sampler, seed, rays, block, top, rows, columns) for top, rows in slabs(view, rays, block)
    ]
    same_shape, same_face, hit = (np.concatenate(each) for each in zip(*parts, strict=True))

    def look_at_geometry() -> NDArray[np.float32]:
        return measure_geometry(view, sampler.fork(), seed, rays, block)

    return Complexity(view.grid, block, rays, len(view.scene.shapes()), same_shape, same_face, hit, look_at_geometry)


def measure_geometry(view: View, sampler: Any, seed: int, rays: int, block: int = 1) -> NDArray[np.float32]:
    """Return g = cos / d^2 of each pilot ray (rows of blocks, columns, K); 0 for one that misses.

    cos: between the ray and the normal of the surface itself (not the shading normal), whichever side is seen; d: from
    where the ray begins, which for some sensors is their near plane. The rays are those of ``measure_complexity``.
    """
    columns = -(-view.grid[1] // block)
    parts = []
    for top, rows in slabs(view, rays, block):
        ray = pilot_rays(view, sampler, seed, rays, block, top, rows, columns)
        found = view.scene.ray_intersect(ray, mi.RayFlags.Minimal, coherent=True)
        geometry = dr.abs(dr.dot(found.n, ray.d)) / dr.square(found.t)
        geometry = dr.select(found.is_valid() & dr.isfinite(geometry), geometry, 0.0)
        parts.append(np.asarray(geometry.numpy()).reshape(rows, columns, -1))
    return np.concatenate(parts)


def slabs(view: View, rays: int, block: int) -> Iterator[tuple[int, int]]:
    """Yield (first, number) of rows of blocks: as many as can be traced at once."""
    rows, columns = (-(-side // block) for side in view.grid)
    most = max(1, MOST_RAYS // (columns * rays * block * block))
    for top in range(0, rows, most):
        yield top, min(most, rows - top)


def measure_rows(
    view: View, sampler: Any, seed: int, rays: int, block: int, top: int, rows: int, columns: int
) -> list[NDArray]:
    """Return same_shape, same_face and hit of ``Complexity`` for ``rows`` rows of blocks from ``top``."""
    per_block = rays * block * block
    shape, face = hits(view, sampler, seed, rays, block, top, rows, columns)
    same_shape, same_face = multiplicity(shape, per_block), multiplicity(face, per_block)
    hit = shape != MISS
    dr.eval(same_shape, same_face, hit)
    return [np.asarray(each.numpy()).reshape(rows, columns, per_block) for each in (same_shape, same_face, hit)]


MISS = 0
"""Shape ID of a ray that hits nothing; hits never have it."""


def hits(
    view: View, sampler: Any, seed: int, rays: int, block: int, top: int, rows: int, columns: int
) -> tuple[Any, Any]:
    """Return shape and face ID (mi.UInt32) of every pilot ray of ``rows`` rows of blocks from ``top``.

    They are ordered by block, then pixel of the block, then ray.
    """
    ray = pilot_rays(view, sampler, seed, rays, block, top, rows, columns)
    found = view.scene.ray_intersect_preliminary(ray, coherent=True)
    instance, shape = numbers_hit(found)
    shape_id = mix(shape + mix(instance)) | 1  # odd: never MISS
    face_id = mix(shape_id ^ mix(found.prim_index)) | 1
    shape_id, face_id = (dr.select(found.is_valid(), number, MISS) for number in (shape_id, face_id))
    dr.eval(shape_id, face_id)
    return shape_id, face_id


def pilot_rays(view: View, sampler: Any, seed: int, rays: int, block: int, top: int, rows: int, columns: int) -> Any:
    """Return the pilot rays of ``rows`` rows of blocks from ``top``, ordered as in ``hits``."""
    per_block = rays * block * block
    lane = dr.arange(mi.UInt32, rows * columns * per_block)
    group, within = divide(lane, per_block)
    pixel_in_block, ray_index = divide(within, rays)
    group_row, group_column = divide(group, columns)
    group_row += dr.opaque(mi.UInt32, top)
    row_in_block, column_in_block = divide(pixel_in_block, block)
    last_row, last_column, side = (dr.opaque(mi.UInt32, n) for n in (view.grid[0] - 1, view.grid[1] - 1, block))
    row = dr.minimum(group_row * side + row_in_block, last_row)
    column = dr.minimum(group_column * side + column_in_block, last_column)
    first = dr.opaque(mi.UInt32, top * columns * block * block)
    sampler.seed_samples(mix(mix(mi.UInt32(seed)) ^ PILOT_KEY), first + divide(lane, rays)[0], ray_index)
    return camera_ray(view, sampler, row, column)[0]


def mean_over_shapes(view: View, sampler: Any, seed: int, rays: int, table: Any) -> Floats:
    """Return the mean over the pilot rays of each pixel (grid) of the entry in ``table`` (mi.Float) of what they hit.

    The table goes by Mitsuba's number of a shape; what is not in it counts 1. Where an instance is hit, its entry and
    that of the shape within are multiplied.
    """
    width = view.grid[1]
    parts = []
    for top, rows in slabs(view, rays, 1):
        ray = pilot_rays(view, sampler, seed, rays, 1, top, rows, width)
        found = view.scene.ray_intersect(ray, mi.RayFlags.Minimal, coherent=True)  # names the shape in an instance
        weight = mi.Float(1.0)
        for number in numbers_hit(found):  # 0, which no shape has, where there is no instance
            named = found.is_valid() & (number != 0) & (number < dr.width(table))
            weight *= dr.select(named, dr.gather(mi.Float, table, number, named), 1.0)
        parts.append(np.asarray(dr.block_sum(weight, rays).numpy(), np.float64).reshape(rows, width) / rays)
    return np.concatenate(parts)
