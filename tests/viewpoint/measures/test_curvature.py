"""Entropy of the angle deficit of what is seen."""

import numpy as np
import pytest

from tracer.viewpoint import sphere
from tracer.viewpoint.measures import curvature, get
from tracer.viewpoint.sight import sight_of
from tracer.viewpoint.subject import open_subject

from ..conftest import mesh_scene


def test_corners_edges_and_sides_of_a_box(triangles):
    # All eight corners of a cube are alike: one class.
    subject = open_subject(triangles)
    assert set(curvature.classes(subject.mesh)) == {0}
    assert get("curvature_entropy").value(sight_of(subject, np.ones(12), 1.0)) == 0


def test_a_pyramid_has_two_kinds_of_corners():
    points = np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0], [0, 0, 2.0]])
    faces = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (0, 2, 1), (0, 3, 2)]
    subject = open_subject(mesh_scene(points, faces))
    deficits = curvature.classes(subject.mesh)
    assert len(set(deficits)) == 2
    found = get("curvature_entropy").value(sight_of(subject, np.ones(6), 1.0))
    assert found == pytest.approx(-0.2 * np.log2(0.2) - 0.8 * np.log2(0.8))
    base = get("curvature_entropy").value(sight_of(subject, np.array([0, 0, 0, 0, 1, 1]), 1.0))
    assert base == 0  # only the four corners that are alike


def test_a_regular_solid_is_even_and_a_cut_one_is_not():
    points, faces = sphere.icosphere(0)
    subject = open_subject(mesh_scene(points, faces))
    assert get("curvature_entropy").value(sight_of(subject, np.ones(20), 1.0)) == 0
    assert get("curvature_entropy").value(sight_of(subject, np.zeros(20), 1.0)) == 0
