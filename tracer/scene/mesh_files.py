"""Read the meshes that people have, part by part: STL, OFF, glTF, 3MF, OBJ and PLY.

A part is a node of glTF, an object of 3MF, or the faces of an OBJ file that share group and material; other formats
have a single part. Binary STL, and PLY without places in a texture, are read here, with all their attributes and in
little memory; everything else is read by trimesh.
"""

from __future__ import annotations

import re
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.extras import require_package
from tracer.errors import SceneError
from tracer.image.colour import decode_srgb
from tracer.scene.mesh_defects import mesh_defect
from tracer.scene.normals import corner_mean, on_one_side
from tracer.scene.parts import Colour, Material, Part, own_names
from tracer.scene.ply_mesh import PlyMesh, read_ply
from tracer.scene.stl_mesh import read_stl

SUFFIXES = (".ply", ".obj", ".stl", ".off", ".glb", ".gltf", ".3mf")
"""Files with these suffixes are meshes."""
BLANK_SHAPE, BLANK_GREY = (2, 2), 102
"""Shape of the even picture, and the grey, that trimesh makes up for a mesh that has places in a texture alone."""
TINY = 1e-30
"""A node of glTF whose volume is less than this share of what it was is flat, and has no normals of its own."""
MOST_HEADER = 1 << 16
"""Bytes within which the header of a PLY file ends."""
FIRST_IS_ZERO = re.compile(rb"^[ \t]*f[ \t](?:[^\n]*[ \t])?0(?:[/ \t\r\n]|$)", re.MULTILINE)
"""A face of an OBJ file with the vertex 0; the first is 1."""


def read_parts(path: Path) -> list[Part]:
    """Return the parts of a mesh file that have faces. Raises SceneError."""
    if not path.is_file():
        raise SceneError(f"There is no mesh '{path}'.")
    if path.suffix.lower() == ".3mf":
        for package in ("lxml", "networkx"):
            require_package(package, package, f"'{path}' is a 3MF file, and reading it", "view")
    try:
        parts = parts_in(path)
    except SceneError:
        raise
    except Exception as error:  # whatever a damaged file makes a reader stumble over
        require_whole(path, None)
        reason = (str(error) or type(error).__name__).splitlines()[0]
        raise SceneError(f"'{path}' does not load as a mesh: {reason}; export it anew.") from None
    return [replace(part, name=name) for part, name in zip(parts, own_names(parts), strict=True)]


def parts_in(path: Path) -> list[Part]:
    """Return the parts of a file. Raises SceneError, and errors of many kinds."""
    own, has_places = own_part(path)
    if own is not None and not has_places:
        return [own]
    try:
        return parts_by_trimesh(path)
    except Exception:  # of binary PLY files, trimesh reads those whose faces all have as many corners
        if own is None:
            raise
        return [own]


def own_part(path: Path) -> tuple[Part | None, bool]:
    """Return what a PLY or binary STL file holds, and whether it has places in a texture, which are not read.

    Returns None for what only trimesh may be able to read. Raises SceneError for faces or vertices that cannot be.
    """
    if path.suffix.lower() == ".stl":
        stl = read_stl(path.read_bytes())
        if stl is None:
            return None, False
        vertices = checked(path, stl[0].astype(np.float64), stl[1])
        return Part(path.name, vertices, stl[1], None, None, Material()), False
    try:
        ply = read_ply(path.read_bytes()) if path.suffix.lower() == ".ply" else None
    except (ValueError, IndexError, KeyError, struct.error):
        return None, False
    if ply is None or not len(ply.faces):
        return None, False
    vertices = checked(path, ply.vertices, ply.faces)
    normals = safe_normals(ply.normals, vertices, ply.faces)
    return Part(path.name, vertices, ply.faces, normals, None, painted(ply), ply.attributes), ply.has_places


def parts_by_trimesh(path: Path) -> list[Part]:
    """Return the parts of a file as trimesh reads them. Raises SceneError, and errors of many kinds."""
    import trimesh  # takes a while

    groups = {"split_objects": True, "split_groups": True} if path.suffix.lower() == ".obj" else {}
    scene = trimesh.load_scene(path, process=False, **groups)
    given = {
        name: normals for name in scene.graph.nodes_geometry if (normals := given_normals(scene, name)) is not None
    }
    geometries = list(scene.dump())
    meshes = [geometry for geometry in geometries if hasattr(geometry, "faces") and len(geometry.faces)]
    require_whole(path, sum(len(mesh.faces) for mesh in meshes))
    if not meshes:
        point_count = sum(len(geometry.vertices) for geometry in geometries if hasattr(geometry, "vertices"))
        what = f"{point_count} points and no face" if point_count else "nothing to look at"
        raise SceneError(f"'{path}' holds {what}; export it as a surface.")
    return [part_of(path, mesh, number, given.get(mesh.metadata["node"])) for number, mesh in enumerate(meshes)]


def given_normals(scene: Any, node: str) -> Floats | None:
    """Return the normals (N, 3) that the file gives to a node of a scene of trimesh, which forgets them on the way."""
    transform, name = scene.graph[node]
    cached = getattr(scene.geometry[name], "_cache", {})  # where trimesh keeps what it has read or worked out
    if "vertex_normals" not in cached or abs(np.linalg.det(transform[:3, :3])) < TINY:
        return None
    return np.asarray(cached["vertex_normals"] @ np.linalg.inv(transform[:3, :3]), np.float64)


def require_whole(path: Path, face_count: int | None) -> None:
    """Raise SceneError, which says what is wrong, for a PLY or OBJ file of which less was read than it should have.

    ``face_count``: number of triangles that were read; None: the reader has given up.
    """
    if path.suffix.lower() == ".ply":
        with path.open("rb") as file:
            declared = re.search(rb"^element face (\d+)", file.read(MOST_HEADER), re.MULTILINE)
        is_whole = face_count is not None and declared is not None and 0 < int(declared[1]) <= face_count
    elif path.suffix.lower() == ".obj":
        is_whole = bool(face_count) and not FIRST_IS_ZERO.search(path.read_bytes())
    else:
        return
    defect = None if is_whole else mesh_defect(path, path.suffix.lower()[1:])
    if defect:
        raise SceneError(f"'{path}' {defect}.")


def part_of(path: Path, mesh: Any, number: int, normals: Floats | None) -> Part:
    """Return a part from a mesh of trimesh, with the normals (N, 3) that its file gives, None if it gives none.

    Raises SceneError if its faces or vertices cannot be.
    """
    faces = np.asarray(mesh.faces, np.int64)
    vertices = checked(path, np.asarray(mesh.vertices, np.float64), faces)
    name = str(mesh.metadata.get("name") or mesh.metadata.get("node") or f"part {number}")
    places = getattr(mesh.visual, "uv", None)
    places = None if places is None or len(places) != len(vertices) else np.asarray(places, np.float64)[:, :2]
    return Part(name, vertices, faces, safe_normals(normals, vertices, faces), places, material_of(mesh))


def checked(path: Path, vertices: Floats, faces: Integers) -> Floats:
    """Return the vertices, with those that no face uses at the place of one. Raises SceneError if they cannot be."""
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise SceneError(
            f"'{path}' has faces that use vertex {faces.max()}, counted from 0, and only {len(vertices)} vertices; "
            "export it anew."
        )
    used = np.zeros(len(vertices), bool)
    used[faces] = True
    if not np.all(np.isfinite(vertices[used])):
        raise SceneError(f"'{path}' has vertices whose coordinates are no numbers; export it anew.")
    return vertices if used.all() else np.where(used[:, None], vertices, vertices[faces[0, 0]])


def safe_normals(given: Floats | None, vertices: Floats, faces: Integers) -> Floats:
    """Return unit normals (N, 3): those given, or else of the faces around; that of one of them where there is none."""
    normals: Floats
    if given is None or given.shape != vertices.shape:
        normals = corner_mean(vertices, faces)
    else:
        normals = np.array(on_one_side(given, vertices, faces))
    length = np.linalg.norm(normals, axis=1)
    lacking = ~np.isfinite(length) | (length < 1e-9)
    if lacking.any():
        some_face = np.zeros(len(vertices), np.int64)
        some_face[faces.reshape(-1)] = np.repeat(np.arange(len(faces)), 3)
        a, b, c = vertices[faces[some_face[lacking]]].transpose(1, 0, 2)
        normals[lacking] = np.cross(b - a, c - a)
        length = np.linalg.norm(normals, axis=1)
        normals[length == 0] = (0.0, 0.0, 1.0)  # all faces around have no area: no ray meets them
        length[length == 0] = 1.0
    return normals / length[:, None]


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


def painted(ply: PlyMesh) -> Material:
    """Return a material in the most frequent colour of the vertices, or else of the faces, of a PLY file."""
    colours = ply.attributes.get("vertex_color", ply.attributes.get("face_color"))
    if colours is None:
        return Material()
    different, counts = np.unique(colours[:, :3], axis=0, return_counts=True)
    return Material(colour=linear(different[counts.argmax()] * (1 if colours.max() > 1 else 255)))


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
