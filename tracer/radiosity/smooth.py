"""Radiosity at the corners of patches, for display: what a patch shows then changes evenly to that of its neighbours.

A corner has the mean of the patches of its shape that meet there, by area. They meet where place and normal are the
same: those of the face, or of its vertices if the shape has any, and then it is meant to look round.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.radiosity.hemisphere import NOTHING
from tracer.radiosity.meshing import cell_corners, cells_of, corners_of
from tracer.radiosity.patches import Patches, in_cell, look_up, on_device

Integers = NDArray[np.int64]
FINENESS = 1 << 20
"""Places along the scene in which corners are told apart."""


class Smooth:
    """Radiosity that changes evenly within patches."""

    def __init__(self, patches: Patches, radiosity: Floats) -> None:
        corner = corner_numbers(patches)
        count = int(corner.max(initial=-1)) + 1
        weights = np.repeat(patches.areas, 3)
        area = np.bincount(corner.ravel(), weights, count)
        self.patches = patches
        self.corner = upload(mi.UInt32, corner)
        sums = [np.bincount(corner.ravel(), weights * np.repeat(channel, 3), count) for channel in radiosity.T]
        self.values = on_device(np.stack(sums, axis=-1) / (np.pi * area[:, None]))

    def at(self, found: Any, ray: Any) -> Any:
        """Return the radiance (mi.Color3f) of each hit (mi.PreliminaryIntersection3f) of a ray; 0 where none is."""
        patch = self.patches.at(found, ray)
        hit = patch != NOTHING
        cuts = dr.gather(mi.UInt32, self.patches.cuts, self.patches.face_at(found), hit)
        weights = corner_weights(found.prim_uv, cuts)
        radiance = mi.Color3f(0)
        for k, weight in enumerate(weights):
            corner = dr.gather(mi.UInt32, self.corner, 3 * patch + k, hit)
            radiance += weight * look_up(self.values, dr.select(hit, corner, NOTHING))
        return radiance


def corner_weights(place: Any, cuts: Any) -> tuple[Any, Any, Any]:
    """Return what each corner of the cell weighs at barycentric places (mi.Point2f) on faces that are cut."""
    _, _, u, v, upper = in_cell(place, cuts)
    return dr.select(upper, u + v - 1, 1 - u - v), dr.select(upper, 1 - u, u), dr.select(upper, 1 - v, v)


def corner_numbers(patches: Patches) -> Integers:
    """Return the numbers (P, 3) of the corners of all patches; those that meet have the same."""
    cuts = patches.cuts.numpy().astype(np.int64)
    places, normals, shapes = [], [], []
    first = 0
    for number, shape in enumerate(each for each in patches.scene.shapes() if each.primitive_count()):
        corners = corners_of(shape)
        n = cuts[first : first + len(corners)]
        first += len(corners)
        face, _ = cells_of(n)
        local = np.concatenate([np.zeros((0, 3, 2)), *(cell_corners(each) for each in n.tolist())])
        places.append(between(corners[face], local))
        normals.append(normalised(between(normals_of(shape, corners)[face], local)))
        shapes.append(np.full(len(face), number))
    place, normal, shape_of = (np.concatenate(part) for part in (places, normals, shapes))
    back = patches.back.numpy()
    front_of = np.concatenate([np.arange(len(back)), np.flatnonzero(back != NOTHING)])
    behind = np.arange(len(patches)) >= len(back)
    extent = float(np.ptp(place, axis=(0, 1)).max(initial=0)) or 1.0
    grid = np.round((place - place.min(axis=(0, 1))) * (FINENESS / extent))
    # Off the middle between two numbers, where normals of boxes like to be.
    turned = np.round(normal * 20 + 0.21)
    same = np.repeat(np.column_stack([shape_of, np.zeros(len(place))])[:, None], 3, axis=1)
    key = np.concatenate([same, grid, turned], axis=-1).astype(np.int64)[front_of]
    key[behind, :, 1] = 1
    _, numbers = np.unique(key.reshape(-1, key.shape[-1]), axis=0, return_inverse=True)
    return numbers.reshape(-1, 3)


def between(corners: Floats, local: Floats) -> Floats:
    """Return what corners (C, 3, 3) have at barycentric coordinates (C, 3, 2)."""
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
    """Return vectors (..., 3) at unit length; those of none as they are."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)
