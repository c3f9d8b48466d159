"""Read the meshes that people have, part by part: STL, OFF, glTF, 3MF, OBJ and PLY.

The files are read by trimesh. A part is a node of glTF, an object of 3MF, or the faces of an OBJ file that share group
and material; other formats have a single part.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core.arrays import Floats, Integers, Singles
from tracer.core.extras import require_package
from tracer.errors import SceneError
from tracer.image.colour import decode_srgb
from tracer.scene.mesh_defects import mesh_defect
from tracer.scene.ply_polygons import read_polygons

SUFFIXES = (".ply", ".obj", ".stl", ".off", ".glb", ".gltf", ".3mf")
"""Files with these suffixes are meshes."""
Colour = tuple[float, float, float]
"""Red, green and blue, linear sRGB."""
GREY: Colour = (0.5, 0.5, 0.5)
"""Colour of a part whose file tells none, linear sRGB."""
BLANK_SHAPE, BLANK_GREY = (2, 2), 102
"""Shape of the even picture, and the grey, that trimesh makes up for a mesh that has places in a texture alone."""
MOST_HEADER = 1 << 16
"""Bytes within which the header of a PLY file ends."""
FIRST_IS_ZERO = re.compile(rb"^[ \t]*f[ \t](?:[^\n]*[ \t])?0(?:[/ \t\r\n]|$)", re.MULTILINE)
"""A face of an OBJ file with the vertex 0; the first is 1."""
DIGITS = 1e-4
"""Lengths of this share of the distance from the origin must be told apart in single precision."""


@dataclass(frozen=True, eq=False)
class Material:
    """What the file tells of a material."""

    name: str = ""
    colour: Colour = GREY
    """Multiplies the texture, if there is one."""
    texture: Singles | None = None
    """(rows, columns, 3): encoded as sRGB, 0 to 1."""
    metallic: float = 0.0
    roughness: float = 1.0


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one material."""

    name: str
    vertices: Floats
    """(N, 3): in world coordinates."""
    faces: Integers
    """(F, 3): vertices of each triangle."""
    normals: Floats
    """(N, 3): unit vectors; of the file, or the mean of the faces around each vertex."""
    places: Floats | None
    """(N, 2): places in the texture, from the lower left; None if there are none."""
    material: Material


def read_parts(path: Path) -> list[Part]:
    """Return the parts of a mesh file that have faces. Raises SceneError."""
    if not path.is_file():
        raise SceneError(f"There is no mesh '{path}'.")
    if path.suffix.lower() == ".3mf":
        for package in ("lxml", "networkx"):
            require_package(package, package, f"'{path}' is a 3MF file, and reading it", "view")
    try:
        geometries = geometries_of(path)
    except Exception as error:  # whatever a damaged file makes a reader stumble over
        require_whole(path, None)
        reason = (str(error) or type(error).__name__).splitlines()[0]
        raise SceneError(f"'{path}' does not load as a mesh: {reason}; export it anew.") from None
    meshes = [geometry for geometry in geometries if hasattr(geometry, "faces") and len(geometry.faces)]
    require_whole(path, sum(len(mesh.faces) for mesh in meshes))
    if not meshes:
        point_count = sum(len(geometry.vertices) for geometry in geometries if hasattr(geometry, "vertices"))
        what = f"{point_count} points and no face" if point_count else "nothing to look at"
        raise SceneError(f"'{path}' holds {what}; export it as a surface.")
    parts = [part_of(path, mesh, number) for number, mesh in enumerate(meshes)]
    return [replace(part, name=name) for part, name in zip(parts, own_names(parts), strict=True)]


def geometries_of(path: Path) -> list[Any]:
    """Return what a file holds, as objects of trimesh. Raises errors of many kinds."""
    import trimesh  # takes a while

    groups = {"split_objects": True, "split_groups": True} if path.suffix.lower() == ".obj" else {}
    try:
        return list(trimesh.load_scene(path, process=False, **groups).dump())
    except Exception:  # of binary PLY files, trimesh reads those whose faces all have as many corners
        polygons = read_polygons(path.read_bytes()) if path.suffix.lower() == ".ply" else None
        if polygons is None:
            raise
        return [trimesh.Trimesh(*polygons, process=False)]


def require_whole(path: Path, face_count: int | None) -> None:
    """Raise SceneError, which says what is wrong, for a PLY or OBJ file of which less was read than it should have.

    ``face_count``: number of triangles that were read; None: the reader has given up.
    """
    data = path.read_bytes()
    if path.suffix.lower() == ".ply":
        declared = re.search(rb"^element face (\d+)", data[:MOST_HEADER], re.MULTILINE)
        is_whole = face_count is not None and declared is not None and 0 < int(declared[1]) <= face_count
    elif path.suffix.lower() == ".obj":
        is_whole = bool(face_count) and not FIRST_IS_ZERO.search(data)
    else:
        return
    defect = None if is_whole else mesh_defect(path, path.suffix.lower()[1:])
    if defect:
        raise SceneError(f"'{path}' {defect}.")


def part_of(path: Path, mesh: Any, number: int) -> Part:
    """Return a part from a mesh of trimesh. Raises SceneError if its faces or vertices cannot be."""
    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise SceneError(
            f"'{path}' has faces that use vertex {faces.max()}, counted from 0, and only {len(vertices)} vertices; "
            "export it anew."
        )
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    if not np.all(np.isfinite(vertices[used])):
        raise SceneError(f"'{path}' has vertices whose coordinates are no numbers; export it anew.")
    name = str(mesh.metadata.get("name") or mesh.metadata.get("node") or f"part {number}")
    places = getattr(mesh.visual, "uv", None)
    places = None if places is None or len(places) != len(vertices) else np.asarray(places, np.float64)[:, :2]
    vertices = np.where(used[:, None], vertices, vertices[faces[0, 0]])
    return Part(name, vertices, faces, safe_normals(mesh.vertex_normals, vertices, faces), places, material_of(mesh))


def safe_normals(given: Any, vertices: Floats, faces: Integers) -> Floats:
    """Return unit normals (N, 3): those given, or that of a face around where there is none."""
    normals: Floats = np.array(given, np.float64)
    a, b, c = vertices[faces].transpose(1, 0, 2)
    across = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    lacking = ~np.isfinite(length) | (length < 1e-9)
    if lacking.any():
        some_face = np.zeros(len(vertices), np.int64)
        some_face[faces.reshape(-1)] = np.repeat(np.arange(len(faces)), 3)
        normals[lacking] = across[some_face[lacking]]
        length = np.linalg.norm(normals, axis=1)
        normals[length == 0] = (0.0, 0.0, 1.0)  # all faces around have no area: no ray meets them
        length[length == 0] = 1.0
    return normals / length[:, None]


def own_names(parts: list[Part]) -> list[str]:
    """Return a name for each part that no other part has."""
    seen: dict[str, int] = {}
    names = []
    for part in parts:
        seen[part.name] = seen.get(part.name, 0) + 1
        names.append(part.name if seen[part.name] == 1 else f"{part.name} {seen[part.name]}")
    return names


def material_of(mesh: Any) -> Material:
    """Return the material of a mesh of trimesh."""
    visual = mesh.visual
    material = getattr(visual, "material", None)
    if material is None:  # colours of vertices or faces: their mean, if there are any
        return Material(colour=linear(visual.main_color)) if getattr(visual, "defined", False) else Material()
    picture = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    texture = None if picture is None else np.asarray(picture.convert("RGB"), np.float32) / np.float32(255)
    is_blank = texture is not None and texture.shape[:2] == BLANK_SHAPE and np.ptp(texture) == 0
    if is_blank and getattr(material, "diffuse", [0])[0] == BLANK_GREY:
        return Material()
    name = str(getattr(material, "name", "") or "")
    return Material(name, colour_of(material, texture is not None), texture, *metal_of(material))


def colour_of(material: Any, has_texture: bool) -> Colour:
    """Return the colour of a material of trimesh, which is linear in glTF and in the materials of OBJ."""
    is_gltf = hasattr(material, "baseColorFactor")
    factor = material.baseColorFactor if is_gltf else None if has_texture else material.main_color
    if factor is None:
        return 1.0, 1.0, 1.0
    red, green, blue = (float(value) / 255 for value in factor[:3])
    return red, green, blue


def metal_of(material: Any) -> tuple[float, float]:
    """Return how metallic and how rough a material of trimesh is; in glTF both are 1 if they are left out.

    Where a picture says it, its mean is taken.
    """
    if not hasattr(material, "metallicFactor"):
        return 0.0, 1.0
    metallic, roughness = (
        1.0 if value is None else float(value) for value in (material.metallicFactor, material.roughnessFactor)
    )
    picture = getattr(material, "metallicRoughnessTexture", None)
    if picture is not None:
        _, green, blue = (np.asarray(picture.convert("RGB"), np.float64) / 255).mean(axis=(0, 1))
        metallic, roughness = metallic * float(blue), roughness * float(green)
    return metallic, roughness


def linear(encoded: Any) -> Colour:
    """Return the colour that is encoded as sRGB, 0 to 255."""
    red, green, blue = (float(value) for value in decode_srgb(np.asarray(encoded, np.float64)[:3] / 255))
    return red, green, blue


def recentred(parts: list[Part]) -> tuple[list[Part], Floats]:
    """Return parts near enough to the origin for single precision, and where their origin was (3,)."""
    low = np.min([part.vertices.min(axis=0) for part in parts], axis=0)
    high = np.max([part.vertices.max(axis=0) for part in parts], axis=0)
    middle: Floats = (low + high) / 2
    if np.abs(middle).max() * DIGITS <= np.linalg.norm(high - low):
        return parts, np.zeros(3)
    return [replace(part, vertices=part.vertices - middle) for part in parts], middle


def content_of(parts: list[Part]) -> Iterator[bytes]:
    """Yield all that decides what pictures of parts show, piece by piece."""
    for part in parts:
        material = part.material
        yield repr((part.name, material.name, material.colour, material.metallic, material.roughness)).encode()
        for array in (part.vertices, part.faces, part.normals, part.places, material.texture):
            yield b"" if array is None else array.tobytes()
