"""Where the cells of patches are: their corners in the world, the normals there, and their shapes."""

from __future__ import annotations

from typing import Any

import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.sphere import normalised_or_zero
from tracer.radiosity.hemisphere import NOTHING
from tracer.radiosity.meshing import cell_corners, cells_of, corners_of
from tracer.radiosity.patches import Patches


def placed_cells(patches: Patches) -> tuple[Floats, Floats, Integers]:
    """Return (corners, normals, shapes) of the C cells, in the order of the patches on their fronts.

    Corners and unit normals at the corners are (C, 3, 3), in world coordinates. ``shapes`` (C,) counts those shapes of
    ``patches.scene`` that have faces, from 0, see ``shapes_with_faces``.
    """
    cuts = patches.cuts.numpy().astype(np.int64)
    places, normals, shapes = [], [], []
    first = 0
    for number, shape in enumerate(shapes_with_faces(patches)):
        corners = corners_of(shape)
        cut_counts = cuts[first : first + len(corners)]
        first += len(corners)
        face, _ = cells_of(cut_counts)
        local = np.concatenate([np.zeros((0, 3, 2)), *(cell_corners(cut_count) for cut_count in cut_counts.tolist())])
        places.append(between(corners[face], local))
        normals.append(normalised_or_zero(between(normals_of(shape, corners)[face], local)))
        shapes.append(np.full(len(face), number))
    return np.concatenate(places), np.concatenate(normals), np.concatenate(shapes)


def shapes_with_faces(patches: Patches) -> list[Any]:
    """Return the shapes that are cut into patches, in the order of their patches."""
    return [shape for shape in patches.scene.shapes() if shape.primitive_count()]


def cells_of_patches(patches: Patches) -> Integers:
    """Return the cell (P,) that each patch is a side of."""
    back = patches.back.numpy()
    return np.concatenate([np.arange(len(back)), np.flatnonzero(back != NOTHING)])


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
