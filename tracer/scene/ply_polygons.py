"""Read binary PLY files whose faces have different numbers of corners, such as triangles and quads."""

from __future__ import annotations

import struct

import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.scene.ply_defects import CORNERS, SCALARS, Element, ply_header


def read_polygons(data: bytes) -> tuple[Floats, Integers] | None:
    """Return vertices (N, 3) and triangles (F, 3), into which polygons are cut, of a binary PLY file.

    Returns None for a file in text, or one that has something else than scalars before its faces. Raises ValueError,
    IndexError, KeyError or struct.error for a damaged file.
    """
    head, end, _ = data.partition(b"end_header")
    if not end:
        return None
    order, elements = ply_header(head.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n"))
    place = data.index(b"\n", len(head)) + 1
    vertices: Floats | None = None
    for element in elements:
        if order is None or (element.scalars is None and element.name != "face"):
            return None
        if element.name == "face":
            return None if vertices is None else (vertices, triangles_of(data, place, order, element))
        kind = np.dtype([(words[-1], order + SCALARS[words[0]]) for words in element.properties])
        table = np.frombuffer(data, kind, element.count, place)
        place += kind.itemsize * element.count
        if element.name == "vertex":
            vertices = np.stack([table[axis].astype(np.float64) for axis in "xyz"], axis=1)
    return None


def triangles_of(data: bytes, place: int, order: str, element: Element) -> Integers:
    """Return triangles (F, 3): the fan around the first corner of each face; ``place``: where the faces begin."""
    begins, counts, corner_kind = corners_of(data, place, order, element)
    triangles, faces = [], []
    for count in np.unique(counts[counts > 2]):
        chosen = np.flatnonzero(counts == count)
        size = corner_kind.itemsize * int(count)
        taken = np.frombuffer(data, np.uint8)[begins[chosen, None] + np.arange(size)]
        corners = np.ascontiguousarray(taken).view(corner_kind).astype(np.int64)
        for k in range(1, int(count) - 1):
            triangles.append(corners[:, [0, k, k + 1]])
            faces.append(chosen)
    if not triangles:
        return np.zeros((0, 3), np.int64)
    in_order = np.argsort(np.concatenate(faces), kind="stable")
    return np.concatenate(triangles)[in_order]


def corners_of(data: bytes, place: int, order: str, element: Element) -> tuple[Integers, Integers, np.dtype]:
    """Return where the corners of each face begin in a file, how many there are, and of what kind they are."""
    steps: list[tuple[struct.Struct | None, int, bool]] = []
    corner_kind = np.dtype(np.int32)
    for words in element.properties:
        if words[0] == "list":
            length, entry = SCALARS[words[1]], SCALARS[words[2]]
            steps.append((struct.Struct(order + length), struct.calcsize(order + entry), words[-1] in CORNERS))
            corner_kind = np.dtype(order + entry) if words[-1] in CORNERS else corner_kind
        else:
            steps.append((None, struct.calcsize(order + SCALARS[words[0]]), False))
    begins, counts = np.zeros(element.count, np.int64), np.zeros(element.count, np.int64)
    for face in range(element.count):  # where a face begins depends on all faces before it
        for length_of, size, is_corners in steps:
            if length_of is None:
                place += size
                continue
            (count,) = length_of.unpack_from(data, place)
            place += length_of.size
            if is_corners:
                begins[face], counts[face] = place, count
            place += count * size
    if place > len(data):
        raise ValueError("the file ends before its faces do")
    return begins, counts, corner_kind
