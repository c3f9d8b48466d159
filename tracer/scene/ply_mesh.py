"""Read PLY files, in text and binary, whose faces have any numbers of corners, with all that they tell of each face.

Other readers refuse files in which triangles and quads are mixed, and forget most properties. In text, every number is
read in double precision, and the file goes on as a binary one.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.scene.ply_defects import CORNERS, SCALARS, Element, ply_header

PLACES = ({"texture_u", "texture_v"}, {"u", "v"}, {"s", "t"})
"""Pairs of properties of vertices that are places in a texture."""
FACE_PLACES = "texcoord"
"""Name of the list of places in a texture that faces may have."""
NOT_ATTRIBUTES = {"x", "y", "z", "nx", "ny", "nz", *(name for pair in PLACES for name in pair)}
"""Properties of vertices that have a meaning of their own."""
COLOURS = (("red", "green", "blue", "alpha"), ("r", "g", "b", "a"))
"""Properties that are a colour together; the last may be left out."""
PARTS = {*"xyzw", *"rgba", *"0123"}
"""Last letters, after an underscore, of properties that are one attribute together."""


@dataclass(frozen=True, eq=False)
class PlyMesh:
    """What a PLY file holds; polygons are cut into triangles."""

    vertices: Floats
    """(N, 3)."""
    faces: Integers
    """(F, 3): vertices of each triangle."""
    normals: Floats | None
    """(N, 3), as they are in the file; None if it has none."""
    attributes: dict[str, Floats]
    """(N, D) or (F, D): values by vertex or by triangle, by the names that Mitsuba gives them, such as vertex_color."""
    has_places: bool
    """Whether vertices or faces have places in a texture, which are not read."""


def read_ply(data: bytes) -> PlyMesh | None:
    """Return what a PLY file holds; None if something else than scalars stands before its faces, or there are none.

    Raises ValueError, IndexError, KeyError or struct.error for a damaged file.
    """
    head, end, _ = data.partition(b"end_header")
    if not end:
        return None
    order, elements = ply_header(head.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n"))
    place = data.index(b"\n", len(head)) + 1
    if order is None:
        data, elements, order, place = *as_binary(data[place:], elements), "<", 0
    table: NDArray[Any] | None = None
    for element in elements:
        if element.name == "face":
            return None if table is None or not element.count else joined(table, data, place, order, element)
        if element.scalars is None:
            return None
        kind = np.dtype([(words[-1], order + SCALARS[words[0]]) for words in element.properties])
        values = np.frombuffer(data, kind, element.count, place)
        place += kind.itemsize * element.count
        table = values if element.name == "vertex" else table
    return None


def as_binary(body: bytes, elements: list[Element]) -> tuple[bytes, list[Element]]:
    """Return the numbers of a file in text as bytes, and its elements with all properties in double precision."""
    numbers = np.fromstring(body.decode("latin-1"), "<f8", sep=" ")
    doubles = [
        replace(
            element,
            properties=[
                ["list", "double", "double", words[-1]] if words[0] == "list" else ["double", words[-1]]
                for words in element.properties
            ],
        )
        for element in elements
    ]
    return numbers.tobytes(), doubles


def joined(table: NDArray[Any], data: bytes, place: int, order: str, element: Element) -> PlyMesh:
    """Return the mesh of a table of vertices and the faces that begin at a place."""
    names = set(table.dtype.names or ())
    vertices, normals = (
        np.stack([table[axis].astype(np.float64) for axis in axes], axis=1) if names.issuperset(axes) else None
        for axes in (("x", "y", "z"), ("nx", "ny", "nz"))
    )
    if vertices is None:
        raise KeyError("vertices without x, y and z")
    triangles, owner, columns = even_faces(data, place, order, element) or uneven_faces(data, place, order, element)
    by_face = {name: values[owner] for name, values in columns.items()}
    by_vertex = {name: table[name] for name in table.dtype.names or () if name not in NOT_ATTRIBUTES}
    attributes = {**attributes_of("vertex_", by_vertex), **attributes_of("face_", by_face)}
    has_places = FACE_PLACES in element.names or any(names >= pair for pair in PLACES)
    return PlyMesh(vertices, triangles, normals, attributes, has_places)


Faces = tuple[Integers, Integers, dict[str, NDArray[Any]]]
"""Triangles (F, 3), the face that each is a part of, and the scalars of faces by name."""


def even_faces(data: bytes, place: int, order: str, element: Element) -> Faces | None:
    """Return the faces if all have as many corners, and other lists as long, as the first has; else None."""
    lengths = dict(
        zip(lists_of(element), lengths_of_lists(data, place, order, replace(element, count=1))[0], strict=True)
    )
    fields: list[tuple[Any, ...]] = []
    for words in element.properties:
        name = words[-1]
        if words[0] == "list":
            fields.append((f"{name} length", order + SCALARS[words[1]]))
            fields.append((name, order + SCALARS[words[2]], (int(lengths[name]),)))
        else:
            fields.append((name, order + SCALARS[words[0]]))
    kind = np.dtype(fields)
    if len(data) - place < kind.itemsize * element.count:
        return None
    table = np.frombuffer(data, kind, element.count, place)
    if any(np.any(table[f"{name} length"] != length) for name, length in lengths.items()):
        return None
    corners = table[corner_list(element)]
    triangles, part_count = fan_of(corners), max(corners.shape[1] - 2, 0)
    owner = np.arange(element.count) if part_count == 1 else np.repeat(np.arange(element.count), part_count)
    return triangles, owner, {name: table[name] for name in scalars_of(element)}


def uneven_faces(data: bytes, place: int, order: str, element: Element) -> Faces:
    """Return the faces, which have any number of corners each. Raises ValueError if the file ends before they do."""
    lengths = lengths_of_lists(data, place, order, element)
    sizes = np.empty((element.count, len(element.properties)), np.int64)
    length_of = dict(zip(lists_of(element), lengths.T, strict=True))
    for column, words in enumerate(element.properties):
        sizes[:, column] = struct.calcsize(order + SCALARS[words[0] if words[0] != "list" else words[1]])
        if words[0] == "list":
            sizes[:, column] += length_of[words[-1]] * struct.calcsize(order + SCALARS[words[2]])
    ends = place + np.cumsum(sizes).reshape(sizes.shape)
    if len(ends) and ends[-1, -1] > len(data):
        raise ValueError("the file ends before its faces do")
    begins = dict(zip(element.names, (ends - sizes).T, strict=True))
    corners, types = corner_list(element), {words[-1]: words for words in element.properties}
    first_corner = begins[corners] + struct.calcsize(order + SCALARS[types[corners][1]])
    triangles, owners = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    for count in np.unique(length_of[corners][length_of[corners] > 2]):
        chosen = np.flatnonzero(length_of[corners] == count)
        kind = np.dtype(order + SCALARS[types[corners][2]])
        triangles.append(fan_of(numbers_at(data, first_corner[chosen], kind, int(count))))
        owners.append(np.repeat(chosen, count - 2))
    owner = np.concatenate(owners)
    in_order = np.argsort(owner, kind="stable")
    columns = {
        name: numbers_at(data, begins[name], np.dtype(order + SCALARS[types[name][0]]))[:, 0]
        for name in scalars_of(element)
    }
    return np.concatenate(triangles)[in_order], owner[in_order], columns


def lists_of(element: Element) -> list[str]:
    """Return the names of the properties that are lists."""
    return [words[-1] for words in element.properties if words[0] == "list"]


def scalars_of(element: Element) -> list[str]:
    """Return the names of the properties that are single numbers."""
    return [words[-1] for words in element.properties if words[0] != "list"]


def corner_list(element: Element) -> str:
    """Return the name of the list of corners. Raises KeyError if there is none."""
    name = next((name for name in lists_of(element) if name in CORNERS), None)
    if name is None:
        raise KeyError("faces without corners")
    return name


def lengths_of_lists(data: bytes, place: int, order: str, element: Element) -> Integers:
    """Return how long the lists (faces, lists) of each face are, as where a face begins depends on all before it."""
    steps: list[tuple[int, struct.Struct, int]] = []
    skipped = 0
    for words in element.properties:
        if words[0] == "list":
            length = struct.Struct(order + SCALARS[words[1]])
            steps.append((skipped, length, struct.calcsize(order + SCALARS[words[2]])))
            skipped = 0
        else:
            skipped += struct.calcsize(order + SCALARS[words[0]])
    lengths = np.zeros((element.count, len(steps)), np.int64)
    for face in range(element.count):
        for column, (before, length, size) in enumerate(steps):
            (count,) = length.unpack_from(data, place + before)
            lengths[face, column] = count
            place += before + length.size + int(count) * size
        place += skipped
    return lengths


def numbers_at(data: bytes, begins: Integers, kind: np.dtype, count: int = 1) -> NDArray[Any]:
    """Return ``count`` numbers (K, count) of a kind from each of the places ``begins`` (K,) on."""
    taken = np.frombuffer(data, np.uint8)[begins[:, None] + np.arange(count * kind.itemsize)]
    return np.ascontiguousarray(taken).view(kind)


def fan_of(corners: NDArray[Any]) -> Integers:
    """Return the triangles around the first corner of polygons (K, C): K (C - 2) of them, polygon by polygon."""
    count = corners.shape[1]
    order = np.array([[0, k, k + 1] for k in range(1, count - 1)], np.int64).reshape(-1)
    return corners[:, order].reshape(-1, 3).astype(np.int64)


def attributes_of(prefix: str, columns: dict[str, NDArray[Any]]) -> dict[str, Floats]:
    """Return the values (K, D) of attributes by name, as Mitsuba names those of PLY files.

    Red, green and blue are ``color``; properties that differ in the end alone, as in flow_x and flow_y or in flow_0 and
    flow_1, are one attribute, ``flow``; any other is an attribute by its own name. ``prefix``: vertex_ or face_.
    """
    groups: dict[str, list[str]] = {}
    colour = next((names for names in COLOURS if set(names[:3]) <= columns.keys()), ())
    for name in columns:
        stem, _, last = name.rpartition("_")
        key = "color" if name in colour else stem if stem and last in PARTS else name
        groups.setdefault(key, []).append(name)
    return {
        f"{prefix}{name.removeprefix(prefix)}": np.stack(
            [columns[column].astype(np.float64) for column in group], axis=1
        )
        for name, group in groups.items()
    }
