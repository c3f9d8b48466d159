"""The subject, which is what is looked at: a scene cut up into surfaces, their true areas, and the sphere around it.

What counts as a surface is a choice: a *face* (a triangle of a mesh, or any other primitive, such as a sphere), a
*shape*, all shapes that share a *bsdf*, faces of the same value of an attribute, or groups of faces that the caller
numbers (atoms). An instance counts as one surface. A face may be of no surface, as sticks between atoms are: it hides
what lies behind it, and counts as background.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.core.device import numbers_hit, table_by_shape, upload
from tracer.errors import SceneError
from tracer.viewpoint.grouping import names_of, number_surfaces

LARGEST = 1e10
"""The radius of a subject is at most this: products of three lengths must stay within the range of single precision."""
NEAREST = 1e-5
"""The radius of a subject is at least this share of its distance from the origin.

Below it, coordinates in single precision have fewer than two digits left for what differs within the subject.
"""

NOT_COUNTED = -1
"""Number of the surface of faces that are of none."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of all meshes of a subject, in world coordinates."""

    vertices: Floats
    """(N, 3)."""
    triangles: Integers
    """(F, 3)."""
    surface: Integers
    """(F,): the surface that each triangle belongs to."""

    @cached_property
    def joining(self) -> tuple[Floats, Integers]:
        """Return the different places (P, 3) of vertices, and the number (N,) of the place of each vertex.

        Vertices that differ in their normals alone have the same place.
        """
        places, number = np.unique(self.vertices, axis=0, return_inverse=True)
        return places, number.reshape(-1)

    @property
    def places(self) -> Floats:
        """(P, 3): the different places of vertices."""
        return self.joining[0]

    @property
    def joined(self) -> Integers:
        """(F, 3): triangles of numbers of places, so that triangles that touch have numbers in common."""
        return self.joining[1][self.triangles]


NO_MESH = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros(0, np.int64))
"""The mesh of a subject that has none."""


@dataclass(frozen=True, eq=False)
class Subject:
    """A scene and its surfaces, numbered from 0. ``tracer.viewpoint.survey.survey`` has an example."""

    scene: Any
    areas: Floats
    """(Z,): true area of each surface; NaN if the area of a shape in it is unknown."""
    weights: Floats
    """(Z,): how much each surface counts in a view, 1 by default; see ``tracer.viewpoint.weights``."""
    names: list[str]
    """Names of the surfaces; empty if they are faces."""
    shape_names: list[str]
    """Names of the shapes, in their order; empty if they mean nothing to a person, as for the balls of a molecule."""
    face_counts: Integers
    """Number of faces of each shape."""
    mesh: Mesh
    centre: Floats
    """(3,): centre of the bounding box."""
    radius: float
    """Radius of the sphere around ``centre`` that holds all vertices, and box corners of shapes without vertices."""
    first_face: Any
    """mi.UInt32: number of the first face of each shape, by Mitsuba's number of the shape."""
    surface_of_face: Any
    """mi.UInt32: surface of each face, Z if it is of none; None if the faces are the surfaces."""
    has_sides: bool = False
    """Whether the front and the back of what was one surface k are surfaces of their own: 2 k and 2 k + 1."""

    @property
    def count(self) -> int:
        """Number of surfaces Z."""
        return len(self.areas)

    @property
    def areas_known(self) -> bool:
        """Whether the true areas of all surfaces are known."""
        return bool(np.all(np.isfinite(self.areas)))

    @property
    def is_weighted(self) -> bool:
        """Whether some surfaces count more than others."""
        return bool(np.any(self.weights != 1))

    def face(self, intersection: Any) -> Any:
        """Return the face (mi.UInt32) that each preliminary intersection hits; for a miss, any number."""
        hit = intersection.is_valid()
        instance, shape = numbers_hit(intersection)
        is_instance = instance != 0
        face = dr.gather(mi.UInt32, self.first_face, dr.select(is_instance, instance, shape), hit)
        return face + dr.select(hit & ~is_instance, intersection.prim_index, 0)

    def surface(self, intersection: Any, ray: Any) -> Any:
        """Return the surface (mi.UInt32) that each preliminary intersection of ``ray`` hits; Z for background."""
        hit, face = intersection.is_valid(), self.face(intersection)
        if self.surface_of_face is not None:
            face = dr.gather(mi.UInt32, self.surface_of_face, face, hit)
        background = dr.opaque(mi.UInt32, self.count)
        if self.has_sides:
            normal = intersection.compute_surface_interaction(ray, mi.RayFlags.Minimal, hit).n
            side = dr.select(dr.dot(normal, ray.d) > 0, mi.UInt32(1), mi.UInt32(0))
            hit &= 2 * face < background  # what counts as background has a number beyond all others
            face = 2 * face + side
        return dr.select(hit, face, background)

    def with_sides(self) -> Subject:
        """Return the subject with its front and back sides as surfaces of their own, each with the area of both."""
        names = [f"{name}{side}" for name in self.names for side in ("", " (back)")]
        areas, weights = np.repeat(self.areas, 2), np.repeat(self.weights, 2)
        mesh = replace(self.mesh, surface=2 * self.mesh.surface)
        return replace(self, areas=areas, weights=weights, names=names, mesh=mesh, has_sides=True)


def open_subject(
    scene: Any,
    surfaces: str = "face",
    groups: Sequence[int] | NDArray | None = None,
    names: Sequence[str] = (),
    patterns: Sequence[str] = (),
) -> Subject:
    """Return a loaded ``mi.Scene`` as a subject, whose views can be measured.

    ``tracer.viewpoint.survey.survey`` has an example.

    ``surfaces``: what counts as one surface, "face", "shape" or "bsdf", or the name of an attribute of meshes, such as
    "face_label". ``patterns``: all shapes whose names match one, such as ``chair*``, are one surface. ``groups``: the
    surface of every face in the order of the scene's shapes, or NOT_COUNTED, instead of both, and ``names``: the names
    of these surfaces. Raises SceneError for a scene without shapes, SettingsError for an unknown kind of surface.
    """
    shapes = list(scene.shapes())
    counts = np.array([shape.primitive_count() for shape in shapes], np.int64)
    if counts.sum() == 0:
        raise SceneError("There is nothing to look at: the scene has no shape, or its meshes have no face.")
    first_faces = np.cumsum(counts) - counts
    if groups is None:
        surface, found_names = number_surfaces(shapes, counts, surfaces, patterns)
    else:
        surface, found_names = np.asarray(groups), list(names)
    mesh, face_areas = gather_mesh(shapes, counts, surface)
    corners = [mesh.vertices] if len(mesh.vertices) else []
    corners += [box_corners(shape) for shape in shapes if not shape.is_mesh() and shape.primitive_count()]
    points = np.concatenate(corners)
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - centre, axis=-1).max())
    check_size(centre, radius)
    faces_are_surfaces = groups is None and surfaces == "face" and not patterns
    counted = surface != NOT_COUNTED
    areas = np.bincount(surface[counted], face_areas[counted], int(surface.max()) + 1).astype(np.float64)
    return Subject(
        scene=scene,
        areas=areas,
        weights=np.ones(len(areas)),
        names=found_names,
        shape_names=names_of(shapes),
        face_counts=counts,
        mesh=mesh,
        centre=centre,
        radius=radius,
        first_face=table_by_shape(shapes, first_faces),
        surface_of_face=None if faces_are_surfaces else upload(mi.UInt32, np.where(counted, surface, len(areas))),
    )


def check_size(centre: Floats, radius: float) -> None:
    """Raise SceneError for a subject that cannot be seen truly in single precision, in which rays are traced."""
    if not np.isfinite(radius) or radius > LARGEST:
        raise SceneError(f"What there is to look at has a radius of {radius:.3g}; make it at most {LARGEST:g}.")
    distance = float(np.abs(centre).max())
    if distance * NEAREST > radius > 0:
        raise SceneError(
            f"What there is to look at has a radius of {radius:.3g} and is {distance:.3g} from the origin, where "
            "single precision cannot tell its parts; move it nearer."
        )


def gather_mesh(shapes: list[Any], counts: Integers, surface: Integers) -> tuple[Mesh, Floats]:
    """Return the triangles of all meshes that are of a surface, and the true area of every face."""
    vertices, triangles, surfaces, areas = [], [], [], []
    vertex_count = first_face = 0
    for shape, count in zip(shapes, counts, strict=True):
        if shape.is_mesh():
            positions = np.array(shape.vertex_positions_buffer(), np.float64).reshape(-1, 3)
            faces = np.array(shape.faces_buffer(), np.int64).reshape(-1, 3)
            a, b, c = positions[faces].transpose(1, 0, 2)
            areas.append(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=-1))
            surface_of_faces = surface[first_face : first_face + count]
            counted = surface_of_faces != NOT_COUNTED
            used = np.zeros(len(positions), bool)  # unused vertices would widen the sphere
            used[faces[counted]] = True
            positions = positions[used]
            vertices.append(positions)
            triangles.append((np.cumsum(used) - 1)[faces[counted]] + vertex_count)
            surfaces.append(surface_of_faces[counted])
            vertex_count += len(positions)
        elif count:
            areas.append(np.full(count, area_of(shape) / count))
        first_face += count
    mesh = Mesh(
        np.concatenate([NO_MESH.vertices, *vertices]),
        np.concatenate([NO_MESH.triangles, *triangles]),
        np.concatenate([NO_MESH.surface, *surfaces]),
    )
    return mesh, np.concatenate(areas)


def area_of(shape: Any) -> float:
    """Return the area of a shape that is no mesh; NaN if it is unknown, as for instances and curves."""
    try:
        area = float(shape.surface_area()[0])
    except RuntimeError:  # Mitsuba raises this for a kind of shape without an area
        return float("nan")
    return area if area > 0 else float("nan")


def box_corners(bounded: Any) -> Floats:
    """Return two opposite corners (2, 3) of the bounding box of a shape or scene."""
    box = bounded.bbox()
    return np.array([np.array(box.min).ravel(), np.array(box.max).ravel()], np.float64)
