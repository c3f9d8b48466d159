"""Radiosity at the corners of patches, for display: radiosity then changes gradually from a patch to its neighbours.

A corner has the mean radiosity, weighted by area, of the patches of its shape that meet there. Patches meet where the
place and the normal of their corners are the same. The normals are those of the vertices if the shape has any, as it is
then meant to look round, and those of the faces otherwise.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.radiosity.hemisphere import NOTHING
from tracer.radiosity.meshing import cell_corners, cells_of, corners_of
from tracer.radiosity.patches import Patches, in_cell, look_up, on_device

FINENESS = 1 << 20
"""Number of steps along the scene's largest extent to which the places of corners are rounded for comparison."""


class Smooth:
    """Radiosity that is interpolated within patches from their corners."""

    def __init__(self, patches: Patches, radiosity: Floats) -> None:
        corner = corner_numbers(patches)
        count = int(corner.max(initial=-1)) + 1
        weights = np.repeat(patches.areas, 3)
        area = np.bincount(corner.ravel(), weights, count)
        self.patches = patches
        self.corner = upload(mi.UInt32, corner)
        sums = [np.bincount(corner.ravel(), weights * np.repeat(channel, 3), count) for channel in radiosity.T]
        self.values = on_device(np.stack(sums, axis=-1) / (np.pi * area[:, None]))

    def at(self, intersection: Any, ray: Any) -> Any:
        """Return the radiance (mi.Color3f) at each hit (mi.PreliminaryIntersection3f) of a ray; 0 where no patch is."""
        patch = self.patches.at(intersection, ray)
        hit = patch != NOTHING
        cuts = dr.gather(mi.UInt32, self.patches.cuts, self.patches.face_at(intersection), hit)
        weights = corner_weights(intersection.prim_uv, cuts)
        radiance = mi.Color3f(0)
        for k, weight in enumerate(weights):
            corner = dr.gather(mi.UInt32, self.corner, 3 * patch + k, hit)
            radiance += weight * look_up(self.values, dr.select(hit, corner, NOTHING))
        return radiance


def corner_weights(place: Any, cuts: Any) -> tuple[Any, Any, Any]:
    """Return the weight (mi.Float) of each corner of a cell at barycentric places (mi.Point2f) on faces.

    ``cuts`` (mi.UInt32): the number of parts that the edges of the faces are cut into.
    """
    _, _, u, v, upper = in_cell(place, cuts)
    return dr.select(upper, u + v - 1, 1 - u - v), dr.select(upper, 1 - u, u), dr.select(upper, 1 - v, v)


def corner_numbers(patches: Patches) -> Integers:
    """Return the numbers (P, 3) of the corners of all patches; corners that meet have the same number."""
    cuts = patches.cuts.numpy().astype(np.int64)
    places, normals, shapes = [], [], []
    first = 0
    for number, shape in enumerate(shape for shape in patches.scene.shapes() if shape.primitive_count()):
        corners = corners_of(shape)
        cut_counts = cuts[first : first + len(corners)]
        first += len(corners)
        face, _ = cells_of(cut_counts)
        local = np.concatenate([np.zeros((0, 3, 2)), *(cell_corners(cut_count) for cut_count in cut_counts.tolist())])
        places.append(between(corners[face], local))
        normals.append(normalised(between(normals_of(shape, corners)[face], local)))
        shapes.append(np.full(len(face), number))
    place, normal, shape_of = (np.concatenate(arrays) for arrays in (places, normals, shapes))
    back = patches.back.numpy()
    front_of = np.concatenate([np.arange(len(back)), np.flatnonzero(back != NOTHING)])
    behind = np.arange(len(patches)) >= len(back)
    largest_extent = float(np.ptp(place, axis=(0, 1)).max(initial=0)) or 1.0
    grid = np.round((place - place.min(axis=(0, 1))) * (FINENESS / largest_extent))
    # The offset keeps common normals, such as those of boxes, away from the middle between two integers.
    directions = np.round(normal * 20 + 0.21)
    prefix = np.repeat(np.column_stack([shape_of, np.zeros(len(place))])[:, None], 3, axis=1)
    key = np.concatenate([prefix, grid, directions], axis=-1).astype(np.int64)[front_of]
    key[behind, :, 1] = 1
    _, numbers = np.unique(key.reshape(-1, key.shape[-1]), axis=0, return_inverse=True)
    return numbers.reshape(-1, 3)


def between(corners: Floats, local: Floats) -> Floats:
    """Return the values (C, 3, 3) at barycentric coordinates (C, 3, 2), interpolated between corners (C, 3, 3)."""
    a, b, c = (corners[:, None, k] for k in range(3))
    return a + local[..., :1] * (b - a) + local[..., 1:] * (c - a)


def normals_of(shape: Any, corners: Floats) -> Floats:
    """Return the normals (F, 3, 3) at the corners (F, 3, 3) of the faces of a mesh."""
    if shape.has_vertex_normals() and not shape.has_face_normals():
        vertices = np.array(shape.vertex_normals_buffer(), np.float64).reshape(-1, 3)
        return vertices[np.array(shape.faces_buffer(), np.int64).reshape(-1, 3)]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.repeat(across[:, None], 3, axis=1)


def normalised(vectors: Floats) -> Floats:
    """Return vectors (..., 3) scaled to unit length; vectors of length 0 stay as they are."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)
