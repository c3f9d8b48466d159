"""Meshes instead of spheres, disks and cylinders: patches are parts of triangles.

Corners lie on the surface, so the triangles lie inside of it, by less than ``sagitta``. The coordinates of textures are
those of the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.errors import SceneError

Integers = NDArray[np.int64]
LEAST, MOST = 12, 96
"""Parts around an axis."""
RINGS = 4096
"""Parts along it at most."""
Surface = Callable[[Floats, Floats], tuple[Floats, Floats]]
"""From texture coordinates u and v (N,) to places (N, 3) and normals (N, 3) on the shape before it is placed."""


def tessellated(scene: Any, size: float) -> Any:
    """Return a scene of meshes only, with triangles about ``size`` long; the scene itself if it is one.

    Raises SceneError for shapes that can be no mesh.
    """
    shapes = scene.shapes()
    if all(shape.is_mesh() for shape in shapes):
        return scene
    refused = [name_of(shape) for shape in shapes if not shape.is_mesh() and shape.class_name() not in SURFACES]
    if refused:
        raise SceneError(
            f"Radiosity knows meshes, spheres, disks and cylinders; these shapes are none: {', '.join(refused)}."
        )
    parts: dict[str, Any] = {"type": "scene"}
    names = [(each, each.id()) for each in (*shapes, *scene.emitters())]
    for number, shape in enumerate(shapes):
        parts[f"shape_{number:06}"] = shape if shape.is_mesh() else mesh_of(shape, size, f"shape_{number:06}")
    if scene.environment() is not None:
        parts["surroundings"] = scene.environment()
    made = mi.load_dict(parts)
    for each, name in names:
        # Loading has renamed those that both scenes share.
        each.set_id(name)
    return made


def sagitta(scene: Any) -> float:
    """Return how far the triangles of a scene's round shapes are from them at most."""
    widths = [
        np.linalg.norm(placed(shape)[:3, 0]) for shape in scene.shapes() if shape.class_name() in ("Sphere", "Cylinder")
    ]
    return float(max(widths, default=0.0) * 2 * (1 - np.cos(np.pi / LEAST)))


def placed(shape: Any) -> Floats:
    """Return the matrix (4, 4) that puts a round shape into the world. Raises SceneError for one without extent."""
    matrix = np.array(mi.traverse(shape)["to_world"].matrix, np.float64).reshape(4, 4)
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < 1e-30:
        raise SceneError(f"{name_of(shape)} has no extent; give it a radius or leave it out.")
    return matrix


def name_of(shape: Any) -> str:
    """Return what to call a shape in a message."""
    return f"'{shape.id()}'" if shape.id() else f"a shape of kind {shape.class_name()}"


def sphere(u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return places and normals of the unit sphere."""
    around, down = 2 * np.pi * u, np.pi * v
    places = np.stack([np.cos(around) * np.sin(down), np.sin(around) * np.sin(down), np.cos(down)], axis=-1)
    return places, places


def disk(u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return places and normals of the unit disk."""
    around = 2 * np.pi * v
    places = np.stack([u * np.cos(around), u * np.sin(around), np.zeros_like(u)], axis=-1)
    return places, np.broadcast_to([0.0, 0.0, 1.0], places.shape)


def cylinder(u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return places and normals of the cylinder of radius 1 from z = 0 to 1."""
    around = 2 * np.pi * u
    normals = np.stack([np.cos(around), np.sin(around), np.zeros_like(u)], axis=-1)
    return normals + v[:, None] * [0.0, 0.0, 1.0], normals


SURFACES: dict[str, Surface] = {"Sphere": sphere, "Disk": disk, "Cylinder": cylinder}


def mesh_of(shape: Any, size: float, name: str) -> Any:
    """Return a mesh of a sphere, a disk or a cylinder, with its material and light."""
    kind = shape.class_name()
    to_world = placed(shape)
    width, height = np.linalg.norm(to_world[:3, 0]), np.linalg.norm(to_world[:3, 2])
    around = int(np.clip(np.ceil(2 * np.pi * width / size), LEAST, MOST))
    u, v = {
        "Sphere": (around, around // 2),
        "Disk": (int(np.clip(np.ceil(width / size), 1, RINGS)), around),
        "Cylinder": (around, int(np.clip(np.ceil(height / size), 1, RINGS))),
    }[kind]
    coordinates, faces = grid(u, v)
    places, normals = SURFACES[kind](*coordinates.T)
    places = places @ to_world[:3, :3].T + to_world[:3, 3]
    normals = normals @ np.linalg.inv(to_world[:3, :3])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    corners = places[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # Poles are points: half of the triangles there have no area.
    kept = np.linalg.norm(across, axis=-1) > 1e-9 * width * max(width, height)
    faces, across = faces[kept], across[kept]
    if inward(shape, places, normals, faces):
        normals = -normals
    turned = np.sum(across * normals[faces].sum(axis=1), axis=-1) < 0
    faces[turned] = faces[turned][:, ::-1]
    return mesh(shape, name, places, normals, coordinates, faces)


def grid(u: int, v: int) -> tuple[Floats, Integers]:
    """Return the corners (N, 2) of u x v rectangles of the unit square, and their triangles (2 u v, 3)."""
    across, down = np.meshgrid(np.arange(u + 1) / u, np.arange(v + 1) / v, indexing="ij")
    corner = np.arange((u + 1) * (v + 1)).reshape(u + 1, v + 1)
    a, b, c, d = (each.ravel() for each in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])
    return np.stack([across.ravel(), down.ravel()], axis=-1), faces


def inward(shape: Any, places: Floats, normals: Floats, faces: Integers) -> bool:
    """Return whether a shape's normals point the other way than ``normals``: a ray is asked to find out."""
    middle, outside = places[faces[0]].mean(axis=0), normals[faces[0]].mean(axis=0)
    reach = np.ptp(places, axis=0).max()
    start = middle + outside / np.linalg.norm(outside) * reach
    ray = mi.Ray3f(mi.Point3f(start.tolist()), mi.Vector3f((middle - start).tolist()))
    found = shape.ray_intersect(ray)
    return bool(found.is_valid()[0]) and float(np.array(found.n).ravel() @ outside) < 0


def mesh(shape: Any, name: str, places: Floats, normals: Floats, coordinates: Floats, faces: Integers) -> Any:
    """Return a mesh with the material and the light of a shape."""
    properties = mi.Properties()
    if shape.bsdf() is not None:
        properties["bsdf"] = shape.bsdf()
    if shape.emitter() is not None:
        radiance = radiance_of(shape)
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": radiance}})
    made = mi.Mesh(name, len(places), len(faces), properties, True, True)
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = upload(mi.Float, places)
    parameters["vertex_normals"] = upload(mi.Float, normals)
    parameters["vertex_texcoords"] = upload(mi.Float, coordinates)
    parameters["faces"] = upload(mi.UInt32, faces)
    parameters.update()
    made.set_id(shape.id() or name)
    return made


def radiance_of(shape: Any) -> list[float]:
    """Return the mean radiance (3,) that a shape emits along its normal, by area; textures are not kept."""
    middles = (dr.arange(mi.Float, 16) + 0.5) / 16
    u, v = dr.meshgrid(middles, middles)
    interaction = dr.zeros(mi.SurfaceInteraction3f, 256)
    interaction.uv = mi.Point2f(u, v)
    interaction.wi = mi.Vector3f(0, 0, 1)
    interaction.shape = mi.ShapePtr(shape)
    found = np.array(mi.Color3f(shape.emitter().eval(interaction)), np.float64).reshape(3, -1)
    across, down = u.numpy().astype(np.float64), v.numpy().astype(np.float64)
    area = {"Sphere": np.sin(np.pi * down), "Disk": across}.get(shape.class_name(), np.ones(256))
    return [float(each) for each in np.average(np.broadcast_to(found, (3, 256)), axis=1, weights=area)]
