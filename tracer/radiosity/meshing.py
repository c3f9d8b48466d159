"""Cut the faces of a scene into patches, and find what each patch reflects and emits."""

from __future__ import annotations

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import table_by_shape, upload
from tracer.errors import SceneError
from tracer.radiosity.albedo import albedo as albedo_of
from tracer.radiosity.hemisphere import NOTHING
from tracer.radiosity.patches import Patches
from tracer.radiosity.remarks import other_than_diffuse
from tracer.radiosity.tessellate import name_of, tessellated

MOST_PATCHES = 1 << 24
"""Largest number of patches, counting only fronts."""
EXTENT = 40
"""Number of patch edges along the scene's largest side, from which their length follows if no size is given."""
FLAT = 1e-7
"""Twice the area of a face over the square of its longest edge, up to which single precision finds it flat."""
SMALLEST = 1e-18
"""Twice the area of a face, up to which single precision cannot tell its normal."""
BRIGHTEST = 1 + 1e-4
"""Largest albedo that is accepted: a surface that reflects all light, with a margin for rounding."""


def cut(scene: Any, size: float | None = None) -> Patches:
    """Return the patches of a loaded scene, with edges at most ``size`` long; without a size, faces are not cut.

    Spheres, disks and cylinders become meshes, and faces without area are left out. Raises SceneError for scenes
    without a solution: other shapes, no light, a light without area, an albedo of more than 1, too many patches.
    """
    check(scene)
    names = other_than_diffuse(scene)
    scene = tessellated(scene, size or extent(scene) / EXTENT)
    shapes = [shape for shape in scene.shapes() if shape.primitive_count()]
    fronts, backs, has_backs, cuts = [], [], [], []
    total = 0
    for shape in shapes:
        corners = corners_of(shape)
        cut_counts = cuts_of(shape, corners, size)
        total += int((cut_counts**2).sum())
        if total > MOST_PATCHES:
            raise SceneError(f"Edges of {size:g} make more than {MOST_PATCHES} patches; allow longer ones.")
        cuts.append(cut_counts)
        if not cut_counts.any():
            has_backs.append(np.zeros(0, bool))
            continue
        face, places = cells_of(cut_counts)
        areas = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)
        fronts.append(side(shape, face, places, areas[face] / cut_counts[face] ** 2, front=True))
        back = side(shape, face, places, areas[face] / cut_counts[face] ** 2, front=False)
        has_patch = bool(np.any(back[3] > 0) or np.any(back[4] > 0))
        backs += [back] if has_patch else []
        has_backs.append(np.full(len(face), has_patch))
    if not fronts:
        raise SceneError("There is nothing to light: no face of the scene has an area.")
    centres, normals, areas, albedo, emitted = (
        np.concatenate([columns[k] for columns in (*fronts, *backs)]) for k in range(5)
    )
    if albedo.max(initial=0) > BRIGHTEST:
        place = centres[albedo.max(axis=1).argmax()].round(3).tolist()
        raise SceneError(
            f"The surface at {place} reflects {albedo.max():.5g} of its light, more than all; make it less."
        )
    if not scene.emitters():
        raise SceneError("There is no light in the scene; give a shape an area emitter, or let the surroundings shine.")
    has_back, cell_counts = np.concatenate(has_backs), np.concatenate(cuts) ** 2
    face_of = np.repeat(np.arange(len(cell_counts)), cell_counts)
    numbers = np.where(has_back, len(has_back) + np.cumsum(has_back) - 1, NOTHING)
    return Patches(
        scene=scene,
        centres=centres,
        normals=normals,
        areas=areas,
        albedo=albedo,
        emitted=emitted,
        not_diffuse=names,
        first_face=first_faces(shapes, [len(cut_counts) for cut_counts in cuts]),
        first_cell=upload(mi.UInt32, np.cumsum(cell_counts) - cell_counts),
        cuts=upload(mi.UInt32, np.concatenate(cuts)),
        back=upload(mi.UInt32, numbers),
        face=upload(mi.UInt32, np.concatenate([face_of, face_of[has_back]])),
    )


def extent(scene: Any) -> float:
    """Return the largest side of the bounding box of a scene."""
    box = scene.bbox()
    return float(np.max(np.array(box.max, np.float64) - np.array(box.min, np.float64)))


def check(scene: Any) -> None:
    """Raise SceneError for scenes and lights that patches cannot stand for."""
    if not any(not shape.is_mesh() or shape.primitive_count() for shape in scene.shapes()):
        raise SceneError("There is nothing to light: the scene has no shape, or its meshes have no face.")
    for emitter in scene.emitters():
        area = mi.has_flag(emitter.flags(), mi.EmitterFlags.Surface)
        if not emitter.is_environment() and (not area or mi.has_flag(emitter.flags(), mi.EmitterFlags.Delta)):
            name = f"'{emitter.id()}'" if emitter.id() else f"of kind {emitter.class_name()}"
            raise SceneError(
                f"Radiosity needs lights that shine every way from an area, and the light {name} does not; use 'area'."
            )


def corners_of(shape: Any) -> Floats:
    """Return the corners (F, 3, 3) of the faces of a mesh, in world coordinates."""
    vertices = np.array(shape.vertex_positions_buffer(), np.float64).reshape(-1, 3)
    if not np.isfinite(vertices).all():
        raise SceneError(f"{name_of(shape)} has corners that are no numbers; mend its file.")
    return vertices[np.array(shape.faces_buffer(), np.int64).reshape(-1, 3)]


def cuts_of(shape: Any, corners: Floats, size: float | None) -> Integers:
    """Return the number of parts (F,) into which the edges of each face are cut; 0 for a face without area."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=1, initial=0)
    twice_area = np.linalg.norm(across, axis=-1)
    has_area = (twice_area > FLAT * longest**2) & (twice_area > SMALLEST)
    cut_counts = np.where(has_area, np.maximum(np.ceil(longest / (size or np.inf) - 1e-9), 1), 0)
    if np.sum(cut_counts**2) > MOST_PATCHES:
        raise SceneError(
            f"Edges of {size:g} cut {name_of(shape)} into more than {MOST_PATCHES} patches; allow longer ones."
        )
    return cut_counts.astype(np.int64)


@cache
def cell_corners(cuts: int) -> Floats:
    """Return the barycentric coordinates (n^2, 3, 2) of the corners of the cells of a face, in the order of cells."""
    cells = []
    for i in range(cuts):
        for j in range(cuts - i):
            cells.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j < cuts - 1:
                cells.append([(i + 1, j + 1), (i, j + 1), (i + 1, j)])
    return np.array(cells, np.float64).reshape(-1, 3, 2) / max(cuts, 1)


def cell_centres(cuts: int) -> Floats:
    """Return the barycentric coordinates (n^2, 2) of the middles of the cells of a face, in the order of cells."""
    middles: Floats = cell_corners(cuts).mean(axis=1)
    return middles


def cells_of(cuts: Integers) -> tuple[Integers, Floats]:
    """Return the face (C,) and the barycentric coordinates (C, 2) of the middle of every cell; ``cuts`` (F,)."""
    places = {n: cell_centres(n) for n in np.unique(cuts).tolist()}
    no_places: Floats = np.zeros((0, 2))
    return np.repeat(np.arange(len(cuts)), cuts**2), np.concatenate([no_places, *(places[n] for n in cuts.tolist())])


def side(shape: Any, face: Integers, places: Floats, areas: Floats, front: bool) -> tuple[Floats, ...]:
    """Return (centres, normals, areas, albedo, emitted) of the front or the back of the C cells of a shape.

    Each has the shape (C, 3), ``areas`` (C,). ``face`` (C,) and ``places`` (C, 2) are those of ``cells_of``.
    """
    intersection = dr.zeros(mi.PreliminaryIntersection3f, len(face))
    intersection.t = 1
    intersection.prim_index = upload(mi.UInt32, face)
    intersection.prim_uv = mi.Point2f(*(upload(mi.Float, coordinate) for coordinate in places.T))
    interaction = shape.compute_surface_interaction(dr.zeros(mi.Ray3f, len(face)), intersection, mi.RayFlags.All)
    interaction.wi = mi.Vector3f(0, 0, 1 if front else -1)
    normals = np.array(interaction.n, np.float64).T * (1 if front else -1)
    # The front of a material is the side of the shading normal.
    normals[np.array(dr.dot(interaction.n, interaction.sh_frame.n)) < 0] *= -1
    albedo = np.zeros((len(face), 3))
    if shape.bsdf() is not None and reflects(shape, front):
        albedo = albedo_of(shape.bsdf(), interaction)
    emitted = np.zeros((len(face), 3))
    if shape.emitter() is not None:
        emitted = np.pi * np.array(shape.emitter().eval(interaction), np.float64).T.reshape(-1, 3)
    centres = np.array(interaction.p, np.float64).T
    if not np.isfinite(albedo).all() or not np.isfinite(emitted).all():
        raise SceneError(
            f"{name_of(shape)} reflects or emits what is no finite number; mend its material or its light."
        )
    return centres, normals, areas, np.broadcast_to(albedo, (len(face), 3)), np.broadcast_to(emitted, (len(face), 3))


def reflects(shape: Any, front: bool) -> bool:
    """Return whether a side of a shape reflects light at all."""
    return bool(mi.has_flag(shape.bsdf().flags(), mi.BSDFFlags.FrontSide if front else mi.BSDFFlags.BackSide))


def first_faces(shapes: list[Any], counts: list[int]) -> Any:
    """Return a table (mi.UInt32) from Mitsuba's number of a shape to the number of its first face.

    ``counts``: number of faces of each shape.
    """
    return table_by_shape(shapes, np.cumsum(counts) - counts)
