"""Pilot rays: primary rays that only tell the IDs of what they hit, and the complexity of these IDs per pixel block.

Each ray has two IDs. The *shape* ID stands for the pair of instance and shape, so that two instances of one object
differ; the *face* ID stands for the primitive within that pair. A ray that misses has IDs of its own. Meshes are told
apart because scenes are opened without Mitsuba's merging of meshes (see ``tracer.scene.load``). In an ``mi.Scene`` that
was loaded with merging, only faces are told apart.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.complexity import measures
from tracer.core import parallel
from tracer.core.arrays import Floats
from tracer.core.device import divide, multiplicity, numbers_hit
from tracer.core.hashing import mix
from tracer.core.protocols import KeyedSampler
from tracer.sampling.samples import camera_ray
from tracer.scene.view import View

PILOT_KEY = 0x9170
"""Part of the seed of pilot rays, which keeps them apart from the picture's samples of whatever seed."""
MOST_RAYS = 1 << 22
"""Most pilot rays that are traced at once, unless a single row of blocks has more."""


@dataclass(frozen=True)
class Complexity:
    """Complexity of what is seen. Measures are (H, W) of the grid; all pixels of a block have the same values.

    K rays, those of all its pixels, belong to a block. Each measure is computed when it is first used.
    ``tracer.criteria.Evidence`` has an example.
    """

    grid: tuple[int, int]
    """(height, width) of the pixels that are sampled."""
    block: int
    """Side of the blocks in pixels."""
    rays: int
    """Pilot rays per pixel."""
    surfaces: int
    """Number of shapes of the scene."""
    same_shape: NDArray[np.uint32]
    """(rows of blocks, columns, K): for each of the K rays of a block, how many of the K hit the same shape."""
    same_face: NDArray[np.uint32]
    """(rows of blocks, columns, K): for each of the K rays of a block, how many of the K hit the same face."""
    hit: NDArray[np.bool_]
    """(rows of blocks, columns, K): whether the ray hit anything."""
    look_at_geometry: Callable[[], NDArray[np.float32]] = field(repr=False)
    """Function that traces the same rays once more, see ``measure_geometry``."""

    @cached_property
    def shape_entropy(self) -> Floats:
        """Entropy of shape IDs in bits."""
        return self.of_blocks(measures.ray_entropy, self.same_shape)

    @cached_property
    def face_entropy(self) -> Floats:
        """Entropy of face IDs in bits."""
        return self.of_blocks(measures.ray_entropy, self.same_face)

    @cached_property
    def shape_gini(self) -> Floats:
        """Gini-Simpson index of shape IDs, 0 to 1 - 1 / K."""
        return self.of_blocks(measures.ray_gini, self.same_shape)

    @cached_property
    def face_gini(self) -> Floats:
        """Gini-Simpson index of face IDs, 0 to 1 - 1 / K."""
        return self.of_blocks(measures.ray_gini, self.same_face)

    @cached_property
    def distinct(self) -> Floats:
        """Number of different shapes that the rays of the block hit; to miss counts as one of them."""
        return self.of_blocks(measures.ray_distinct, self.same_shape)

    @cached_property
    def viewpoint(self) -> Floats:
        """C(V) of the paper, with shapes as surfaces and the block as image."""
        return self.of_blocks(partial(measures.ray_viewpoint, surfaces=self.surfaces), self.same_shape, self.hit)

    @cached_property
    def geometry_contrast(self) -> Floats:
        """1 - H / log K of the K numbers of ``measure_geometry``, 0 to 1; its rays are traced at the first use.

        Equation 10 of J. Rigau, M. Feixas and M. Sbert, "Entropy-based adaptive sampling", Graphics Interface 2003.
        """
        return self.expand(measures.contrast(self.look_at_geometry()))

    def of_blocks(self, measure: Callable[..., Floats], *arrays: NDArray) -> Floats:
        """Return a measure of the K rays of each block, from arrays (rows of blocks, columns, K), as (H, W)."""
        return self.expand(parallel.fill(np.empty(self.same_shape.shape[:2]), measure, *arrays))

    def expand(self, values: Floats) -> Floats:
        """Return values of blocks (rows of blocks, columns) as values of pixels (H, W)."""
        if self.block == 1:
            return values
        repeated = values.repeat(self.block, axis=0).repeat(self.block, axis=1)
        return repeated[: self.grid[0], : self.grid[1]]


def measure_complexity(view: View, sampler: KeyedSampler, seed: int, rays: int, block: int = 1) -> Complexity:
    """Trace ``rays`` pilot rays per pixel and measure the complexity of blocks of ``block`` x ``block`` pixels.

    Where the size of the image is no multiple of the block, blocks at the edge are filled with its last pixels again.
    """
    columns = -(-view.grid[1] // block)
    parts = [
        measure_rows(view, sampler, seed, rays, block, top, rows, columns) for top, rows in slabs(view, rays, block)
    ]
    same_shape, same_face, hit = (np.concatenate(rows_of_blocks) for rows_of_blocks in zip(*parts, strict=True))

    def look_at_geometry() -> NDArray[np.float32]:
        return measure_geometry(view, sampler.fork(), seed, rays, block)

    return Complexity(view.grid, block, rays, len(view.scene.shapes()), same_shape, same_face, hit, look_at_geometry)


def measure_geometry(view: View, sampler: KeyedSampler, seed: int, rays: int, block: int = 1) -> NDArray[np.float32]:
    """Return g = cos / d^2 of each pilot ray (rows of blocks, columns, K); 0 for one that misses.

    cos is taken between the ray and the normal of the surface itself (not the shading normal), whichever side is seen;
    d is the distance from where the ray begins, which for some sensors is their near plane. The rays are those of
    ``measure_complexity``.
    """
    columns = -(-view.grid[1] // block)
    parts = []
    for top, rows in slabs(view, rays, block):
        ray = pilot_rays(view, sampler, seed, rays, block, top, rows, columns)
        intersection = view.scene.ray_intersect(ray, mi.RayFlags.Minimal, coherent=True)
        geometry = dr.abs(dr.dot(intersection.n, ray.d)) / dr.square(intersection.t)
        geometry = dr.select(intersection.is_valid() & dr.isfinite(geometry), geometry, 0.0)
        parts.append(np.asarray(geometry.numpy()).reshape(rows, columns, -1))
    return np.concatenate(parts)


def slabs(view: View, rays: int, block: int) -> Iterator[tuple[int, int]]:
    """Yield (first row, number of rows) of blocks, as many as can be traced at once, until all rows are covered."""
    rows, columns = (-(-side // block) for side in view.grid)
    most_rows = max(1, MOST_RAYS // (columns * rays * block * block))
    for top in range(0, rows, most_rows):
        yield top, min(most_rows, rows - top)


def measure_rows(
    view: View, sampler: KeyedSampler, seed: int, rays: int, block: int, top: int, rows: int, columns: int
) -> list[NDArray]:
    """Return same_shape, same_face and hit of ``Complexity`` for ``rows`` rows of blocks from row ``top`` on."""
    per_block = rays * block * block
    shape, face = hits(view, sampler, seed, rays, block, top, rows, columns)
    same_shape, same_face = multiplicity(shape, per_block), multiplicity(face, per_block)
    hit = shape != MISS
    dr.eval(same_shape, same_face, hit)
    return [np.asarray(array.numpy()).reshape(rows, columns, per_block) for array in (same_shape, same_face, hit)]


MISS = 0
"""Shape ID and face ID of a ray that hits nothing; no ray that hits has it."""


def hits(
    view: View, sampler: KeyedSampler, seed: int, rays: int, block: int, top: int, rows: int, columns: int
) -> tuple[mi.UInt32, mi.UInt32]:
    """Return shape IDs and face IDs of the pilot rays of ``rows`` rows of blocks from row ``top`` on.

    They are ordered by block, then pixel of the block, then ray.
    """
    ray = pilot_rays(view, sampler, seed, rays, block, top, rows, columns)
    intersection = view.scene.ray_intersect_preliminary(ray, coherent=True)
    shape_id, face_id = surface_ids(*numbers_hit(intersection), intersection.prim_index)
    shape_id, face_id = (dr.select(intersection.is_valid(), number, MISS) for number in (shape_id, face_id))
    dr.eval(shape_id, face_id)
    return shape_id, face_id


def surface_ids(instance: mi.UInt32, shape: mi.UInt32, face: mi.UInt32) -> tuple[mi.UInt32, mi.UInt32]:
    """Return shape IDs and face IDs from the numbers of instances, of shapes and of faces of a shape."""
    shape_id = mix(shape + mix(instance)) | 1  # odd, so never MISS
    # The shape is hashed twice: else face 2 of shape 3 would have the ID of face 3 of shape 2.
    return shape_id, mix(mix(shape_id) ^ mix(face)) | 1


def pilot_rays(
    view: View, sampler: KeyedSampler, seed: int, rays: int, block: int, top: int, rows: int, columns: int
) -> mi.RayDifferential3f:
    """Return the pilot rays of ``rows`` rows of blocks from row ``top`` on, ordered as in ``hits``."""
    per_block = rays * block * block
    lane = dr.arange(mi.UInt32, rows * columns * per_block)
    group, ray_in_block = divide(lane, per_block)
    pixel_in_block, ray_index = divide(ray_in_block, rays)
    group_row, group_column = divide(group, columns)
    group_row += dr.opaque(mi.UInt32, top)
    row_in_block, column_in_block = divide(pixel_in_block, block)
    last_row, last_column, side = (
        dr.opaque(mi.UInt32, number) for number in (view.grid[0] - 1, view.grid[1] - 1, block)
    )
    row = dr.minimum(group_row * side + row_in_block, last_row)
    column = dr.minimum(group_column * side + column_in_block, last_column)
    first_pixel = dr.opaque(mi.UInt32, top * columns * block * block)
    sampler.seed_samples(mix(mix(mi.UInt32(seed)) ^ PILOT_KEY), first_pixel + divide(lane, rays)[0], ray_index)
    return camera_ray(view, sampler, row, column)[0]


def mean_over_shapes(view: View, sampler: KeyedSampler, seed: int, rays: int, table: mi.Float) -> Floats:
    """Return the mean (grid) of the weights of the shapes that the pilot rays of each pixel hit.

    ``table``: weights at Mitsuba's numbers of the shapes; what is not in it counts 1. Where a ray hits an
    instance, the weights of the instance and of the shape within are multiplied.
    """
    width = view.grid[1]
    parts = []
    for top, rows in slabs(view, rays, 1):
        ray = pilot_rays(view, sampler, seed, rays, 1, top, rows, width)
        # Unlike a preliminary intersection, this one tells the shape within an instance.
        intersection = view.scene.ray_intersect(ray, mi.RayFlags.Minimal, coherent=True)
        weight = mi.Float(1.0)
        for number in numbers_hit(intersection):  # 0, which no shape has, where there is no instance
            in_table = intersection.is_valid() & (number != 0) & (number < dr.width(table))
            weight *= dr.select(in_table, dr.gather(mi.Float, table, number, in_table), 1.0)
        parts.append(np.asarray(dr.block_sum(weight, rays).numpy(), np.float64).reshape(rows, width) / rays)
    return np.concatenate(parts)
