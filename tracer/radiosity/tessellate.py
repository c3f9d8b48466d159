"""Meshes that replace spheres, disks and cylinders, because patches are parts of triangles.

The corners of the triangles lie on the surface, so the triangles lie inside it, by less than ``sagitta``. Texture
coordinates are those of the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.errors import SceneError

LEAST, MOST = 12, 96
"""Smallest and largest number of parts around the axis of a shape."""
RINGS = 4096
"""Largest number of parts along the axis of a cylinder, or along the radius of a disk."""
Surface = Callable[[Floats, Floats], tuple[Floats, Floats]]
"""From texture coordinates u and v (N,) to places (N, 3) and normals (N, 3) on a shape in its own coordinates."""


def tessellated(scene: Any, size: float) -> Any:
    """Return the scene with meshes only, or the scene itself if it has no other shapes.

    ``size``: length of the edges of new triangles, about. Raises SceneError for shapes that no mesh can replace.
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
    names_by_node = [(node, node.id()) for node in (*shapes, *scene.emitters())]
    for number, shape in enumerate(shapes):
        part = shape if shape.is_mesh() else mesh_of(shape, size, f"shape_{number:06}")
        parts[f"shape_{number:06}"] = part
        names_by_node.append((part, shape.id()))
    if scene.environment() is not None:
        parts["surroundings"] = scene.environment()
    mesh_scene = mi.load_dict(parts)
    for node, name in names_by_node:
        # Loading has renamed all shapes, and the emitters that both scenes share.
        node.set_id(name)
    return mesh_scene


def sagitta(scene: Any) -> float:
    """Return an upper bound for the distance from a scene's round shapes to the triangles that replace them."""
    widths = [
        np.linalg.norm(placed(shape)[:3, 0]) for shape in scene.shapes() if shape.class_name() in ("Sphere", "Cylinder")
    ]
    return float(max(widths, default=0.0) * 2 * (1 - np.cos(np.pi / LEAST)))


def placed(shape: Any) -> Floats:
    """Return the matrix (4, 4) from a round shape to the world. Raises SceneError for a shape without extent."""
    matrix = np.array(mi.traverse(shape)["to_world"].matrix, np.float64).reshape(4, 4)
    if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < 1e-30:
        raise SceneError(f"{name_of(shape)} has no extent; give it a radius or leave it out.")
    return matrix


def name_of(shape: Any) -> str:
    """Return what to call a shape in a message."""
    return f"'{shape.id()}'" if shape.id() else f"a shape of kind {shape.class_name()}"


def sphere(u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return places and normals (N, 3) of the unit sphere."""
    around, down = 2 * np.pi * u, np.pi * v
    places = np.stack([np.cos(around) * np.sin(down), np.sin(around) * np.sin(down), np.cos(down)], axis=-1)
    return places, places


def disk(u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return places and normals (N, 3) of the unit disk."""
    around = 2 * np.pi * v
    places = np.stack([u * np.cos(around), u * np.sin(around), np.zeros_like(u)], axis=-1)
    return places, np.broadcast_to([0.0, 0.0, 1.0], places.shape)


def cylinder(u: Floats, v: Floats) -> tuple[Floats, Floats]:
    """Return places and normals (N, 3) of the cylinder of radius 1 from z = 0 to 1."""
    around = 2 * np.pi * u
    normals = np.stack([np.cos(around), np.sin(around), np.zeros_like(u)], axis=-1)
    return normals + v[:, None] * [0.0, 0.0, 1.0], normals


SURFACES: dict[str, Surface] = {"Sphere": sphere, "Disk": disk, "Cylinder": cylinder}
"""Surfaces of the shapes that meshes can replace, by Mitsuba's name of their class."""


def mesh_of(shape: Any, size: float, name: str) -> Any:
    """Return a mesh of a sphere, a disk or a cylinder, with its material and light.

    ``size``: length of the edges of its triangles, about. ``name``: ID of the mesh if the shape has none.
    """
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
    # Half of the triangles at a pole have no area, because the pole is a single point.
    has_area = np.linalg.norm(across, axis=-1) > 1e-9 * width * max(width, height)
    faces, across = faces[has_area], across[has_area]
    if inward(shape, places, normals, faces):
        normals = -normals
    is_turned = np.sum(across * normals[faces].sum(axis=1), axis=-1) < 0
    faces[is_turned] = faces[is_turned][:, ::-1]
    return mesh(shape, name, places, normals, coordinates, faces)


def grid(u: int, v: int) -> tuple[Floats, Integers]:
    """Return the corners (N, 2) of u x v rectangles of the unit square, and their triangles (2 u v, 3)."""
    across, down = np.meshgrid(np.arange(u + 1) / u, np.arange(v + 1) / v, indexing="ij")
    corner = np.arange((u + 1) * (v + 1)).reshape(u + 1, v + 1)
    a, b, c, d = (corners.ravel() for corners in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], axis=-1), np.stack([a, c, d], axis=-1)])
    return np.stack([across.ravel(), down.ravel()], axis=-1), faces


def inward(shape: Any, places: Floats, normals: Floats, faces: Integers) -> bool:
    """Return whether the normals of a shape point opposite to ``normals`` (N, 3), as found with a ray."""
    middle, outside = places[faces[0]].mean(axis=0), normals[faces[0]].mean(axis=0)
    reach = np.ptp(places, axis=0).max()
    start = middle + outside / np.linalg.norm(outside) * reach
    ray = mi.Ray3f(mi.Point3f(start.tolist()), mi.Vector3f((middle - start).tolist()))
    hit = shape.ray_intersect(ray)
    return bool(hit.is_valid()[0]) and float(np.array(hit.n).ravel() @ outside) < 0


def mesh(shape: Any, name: str, places: Floats, normals: Floats, coordinates: Floats, faces: Integers) -> Any:
    """Return a mesh with the material and the light of a shape.

    ``places``, ``normals`` (N, 3) and ``coordinates`` (N, 2) are those of its vertices; ``faces`` is (F, 3).
    """
    properties = mi.Properties()
    if shape.bsdf() is not None:
        properties["bsdf"] = shape.bsdf()
    if shape.emitter() is not None:
        radiance = radiance_of(shape)
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": radiance}})
    result = mi.Mesh(name, len(places), len(faces), properties, True, True)
    parameters = mi.traverse(result)
    parameters["vertex_positions"] = upload(mi.Float, places)
    parameters["vertex_normals"] = upload(mi.Float, normals)
    parameters["vertex_texcoords"] = upload(mi.Float, coordinates)
    parameters["faces"] = upload(mi.UInt32, faces)
    parameters.update()
    result.set_id(shape.id() or name)
    return result


def radiance_of(shape: Any) -> list[float]:
    """Return the mean radiance (3,) over its area that a shape emits along its normal; a texture is averaged."""
    middles = (dr.arange(mi.Float, 16) + 0.5) / 16
    u, v = dr.meshgrid(middles, middles)
    interaction = dr.zeros(mi.SurfaceInteraction3f, 256)
    interaction.uv = mi.Point2f(u, v)
    interaction.wi = mi.Vector3f(0, 0, 1)
    interaction.shape = mi.ShapePtr(shape)
    radiance = np.array(mi.Color3f(shape.emitter().eval(interaction)), np.float64).reshape(3, -1)
    across, down = u.numpy().astype(np.float64), v.numpy().astype(np.float64)
    area = {"Sphere": np.sin(np.pi * down), "Disk": across}.get(shape.class_name(), np.ones(256))
    return [float(channel) for channel in np.average(np.broadcast_to(radiance, (3, 256)), axis=1, weights=area)]
