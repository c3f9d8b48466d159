"""Binary STL: equal corners are one vertex, whatever the order, and even where two numbers of 64 bits are equal."""

import numpy as np
import trimesh

from tracer.scene import stl_mesh
from tracer.scene.stl_mesh import joined, read_stl


def test_triangles_share_vertices():
    ball = trimesh.creation.icosphere(subdivisions=2)
    vertices, faces = read_stl(ball.export(file_type="stl"))
    assert len(vertices) == len(ball.vertices)
    assert np.array_equal(vertices[faces], ball.triangles.astype(np.float32))
    assert read_stl(ball.export(file_type="stl")[:-1]) is None
    assert read_stl(b"solid ball\nendsolid") is None


def test_both_zeros_are_one_place():
    places, number = joined(np.array([[0.0, 1, 2], [-0.0, 1, 2], [2, 1, 0.0]], np.float32))
    assert len(places) == 2
    assert number[0] == number[1] != number[2]


def test_places_with_equal_numbers_stay_apart(monkeypatch):
    monkeypatch.setattr(stl_mesh, "FACTORS", np.zeros(3, np.uint64))  # all numbers are 0
    points = np.random.default_rng(0).integers(0, 3, (50, 3)).astype(np.float32)
    places, number = joined(points)
    assert len(places) == len(np.unique(points, axis=0))
    assert np.array_equal(places[number], points)
