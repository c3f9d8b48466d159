"""Attributes of PLY files whose faces are triangles, quads and more: as those of the same triangles alone."""

import struct

import mitsuba as mi
import numpy as np
import pytest

from tracer.scene.mesh_files import read_parts
from tracer.scene.ply_mesh import attributes_of, read_ply
from tracer.viewpoint.source import Counted, open_source

CORNERS = [[k & 1, k >> 1 & 1, k >> 2] for k in range(8)]
MIXED = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
"""The sides of a cube: four quads, and two pairs of triangles."""
SIDE = [0, 1, 2, 2, 3, 3, 4, 5]
"""The side that each face is a part of."""
HEAT = [5, 5, 5, 5, 8, 8, 8, 8]
"""A value for each corner: one below, another above."""


def ply(faces, labels, form):
    """Return a PLY file with the float ``label_0`` of faces before their corners, a byte after them, and heat."""
    header = f"ply\nformat {form} 1.0\ncomment made up\nelement vertex 8\nproperty float x\nproperty float y\n"
    header += f"property float z\nproperty uchar heat\nelement face {len(faces)}\nproperty float label_0\n"
    header += "property list uchar int vertex_indices\nproperty uchar flag\nend_header\n"
    if form == "ascii":
        rows = [(*corner, heat) for corner, heat in zip(CORNERS, HEAT, strict=True)]
        rows += [(label, len(face), *face, 9) for face, label in zip(faces, labels, strict=True)]
        return (header + "\n".join(" ".join(map(str, row)) for row in rows)).encode()
    sign = "<" if "little" in form else ">"
    data = b"".join(struct.pack(f"{sign}3fB", *corner, heat) for corner, heat in zip(CORNERS, HEAT, strict=True))
    for face, label in zip(faces, labels, strict=True):
        data += struct.pack(f"{sign}fB{len(face)}iB", label, len(face), *face, 9)
    return header.encode() + data


def triangles_alone():
    """Return the triangles (F, 3) of MIXED, and the side of each."""
    fans = [(face[0], *face[k : k + 2]) for face in MIXED for k in range(1, len(face) - 1)]
    sides = [side for face, side in zip(MIXED, SIDE, strict=True) for _ in face[2:]]
    return fans, sides


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_attributes_of_mixed_faces_are_those_of_triangles(tmp_path, form):
    """Mitsuba reads the triangles alone, with label_0, and names it face_label as we do."""
    fans, sides = triangles_alone()
    (tmp_path / "mixed.ply").write_bytes(ply(MIXED, SIDE, form))
    (tmp_path / "triangles.ply").write_bytes(ply(fans, sides, form))
    scene = {"type": "scene", "mesh": {"type": "ply", "filename": str(tmp_path / "triangles.ply")}}
    theirs = np.array(mi.load_dict(scene).shapes()[0].attribute_buffer("face_label"))
    assert theirs.tolist() == sides
    for name in ("mixed", "triangles"):
        (part,) = read_parts(tmp_path / f"{name}.ply")
        assert part.faces.tolist() == [list(triangle) for triangle in fans]
        assert part.attributes["face_label"].ravel().tolist() == sides
        assert part.attributes["face_flag"].ravel().tolist() == [9] * 12
        by_side = open_source(tmp_path / f"{name}.ply", Counted("face_label")).subject
        assert by_side.names == [f"face_label {side}" for side in range(6)]
        assert by_side.areas == pytest.approx(np.ones(6))
        by_heat = open_source(tmp_path / f"{name}.ply", Counted("vertex_heat")).subject
        assert by_heat.names == ["vertex_heat 5", "vertex_heat 8"]
        assert by_heat.areas.sum() == pytest.approx(6)


def test_names_of_attributes():
    columns = dict.fromkeys(["red", "green", "blue", "alpha", "flow_x", "flow_y", "vertex_mass", "age"], np.ones(3))
    shapes = {name: values.shape for name, values in attributes_of("vertex_", columns).items()}
    assert shapes == {"vertex_color": (3, 4), "vertex_flow": (3, 2), "vertex_mass": (3, 1), "vertex_age": (3, 1)}


def test_faces_of_two_corners_are_left_out():
    mesh = read_ply(ply([[0, 1], [0, 1, 2], [3, 4, 5, 6]], [1, 2, 3], "binary_little_endian"))
    assert mesh.faces.tolist() == [[0, 1, 2], [3, 4, 5], [3, 5, 6]]
    assert mesh.attributes["face_label"].ravel().tolist() == [2, 3, 3]
    with pytest.raises(ValueError, match="ends before its faces do"):
        read_ply(ply([[0, 1], [0, 1, 2]], [1, 2], "binary_little_endian")[:-1])
