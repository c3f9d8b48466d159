"""Entropy of the angle deficit of the vertices that are seen."""

from dataclasses import replace

import numpy as np
import pytest

from tracer.core import sphere
from tracer.viewpoint.direction_measure import stand
from tracer.viewpoint.item_buffer import Rays, Viewpoints
from tracer.viewpoint.measures import curvature, get
from tracer.viewpoint.observation import sight_of
from tracer.viewpoint.surfaces import open_subject
from tracer.viewpoint.survey import survey

from ..conftest import mesh_scene

PYRAMID = np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0], [0, 0, 2.0]])
PYRAMID_FACES = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (0, 2, 1), (0, 3, 2)]


def value(subject, vertices):
    sight = replace(sight_of(subject, np.ones(subject.count), 1.0), vertices=np.asarray(vertices, int))
    return get("curvature_entropy").value(sight)


def class_of(deficit):
    """Return the class of an angle deficit in the published program: 255 of equal width from -2 pi, and the last."""
    return int((256 - 1) * ((deficit + 2 * np.pi) / (4 * np.pi)))


def deficits_by_hand(places, faces):
    """Return 2 pi - sum of the angles at each place, by the law of cosines."""
    found = np.full(len(places), 2 * np.pi)
    for face in faces:
        for k in range(3):
            a, b, c = (places[face[(k + turn) % 3]] for turn in range(3))
            ab, ac, bc = (np.linalg.norm(side) for side in (b - a, c - a, c - b))
            found[face[k]] -= np.arccos((ab**2 + ac**2 - bc**2) / (2 * ab * ac))
    return found


def entropy(labels):
    shares = np.unique(labels, return_counts=True)[1] / len(labels)
    return -np.sum(shares * np.log2(shares))


def bumpy(level=3):
    """Return a smooth mesh, of 1280 faces at level 3."""
    points, faces = sphere.icosphere(level)
    height = 1 + 0.3 * np.sin(5 * points[:, 0]) * np.sin(5 * points[:, 1] + 1) * np.cos(5 * points[:, 2])
    return points * height[:, None], faces


def test_corners_of_a_box(triangles):
    # All eight corners of a cube are alike: 2 pi - 3 pi / 2, which is 159.375 classes of 4 pi / 255 from -2 pi.
    subject = open_subject(triangles)
    assert set(curvature.classes(subject.mesh)) == {159}
    assert value(subject, range(8)) == 0


def test_classes_are_the_same_for_all_meshes():
    """Of 256 from -2 pi to 2 pi, whatever deficits a mesh has."""
    places, faces = bumpy()
    subject = open_subject(mesh_scene(places, faces))
    assert len(subject.mesh.places) == 642
    expected = [class_of(deficit) for deficit in deficits_by_hand(subject.mesh.places, subject.mesh.joined)]
    assert len(set(expected)) > 20
    found = curvature.classes(subject.mesh)
    assert np.mean(found != expected) < 0.01  # but for rounding
    assert value(subject, range(0, 642, 2)) == pytest.approx(entropy(expected[::2]), abs=0.05)


def test_one_odd_vertex_does_not_put_all_others_in_one_class():
    places, faces = bumpy()
    spike = places.copy()
    spike[0] *= 30
    near = [k for k in range(642) if any(k in face and 0 in face for face in faces)]
    others = np.setdiff1d(np.arange(642), near)
    found = []
    for points in (places, spike):
        subject = open_subject(mesh_scene(points, faces))
        numbers = [np.linalg.norm(subject.mesh.places - points[k], axis=1).argmin() for k in others]
        found.append(value(subject, numbers))
    assert found[0] == found[1] > 3


def test_regular_solids_are_even_though_their_deficit_is_the_limit_of_a_class():
    octahedron = np.concatenate([np.eye(3), -np.eye(3)])  # 2 pi / 3: 170 classes from -2 pi
    faces = [(a, b, c) for a in (0, 3) for b in (1, 4) for c in (2, 5)]
    for turn in sphere.evenly(20):
        right, up = sphere.frame(turn)
        subject = open_subject(mesh_scene(octahedron @ np.stack([right, up, turn]), faces))
        assert set(curvature.classes(subject.mesh)) == {170}
    points, faces = sphere.icosphere(0)
    subject = open_subject(mesh_scene(points, faces))
    assert value(subject, range(12)) == 0
    assert value(subject, []) == 0


def test_only_the_vertices_that_are_seen_count():
    """From below a pyramid its tip is not seen, from above all but none of the corners is hidden."""
    subject = open_subject(mesh_scene(PYRAMID, PYRAMID_FACES))
    place = stand(subject)
    views = place.viewpoints(np.array([[0.0, 0, 1], [0, 0, -1]]))
    found = survey(subject, views, place.lens, Rays(side=32), ["curvature_entropy"])["curvature_entropy"]
    assert found == pytest.approx([-0.2 * np.log2(0.2) - 0.8 * np.log2(0.8), 0])


def test_vertices_of_faces_that_are_seen_may_be_hidden():
    """A board hides two of the four corners of each face behind it, but not the faces."""
    board = np.array([[-0.2, -9, 1.0], [0.2, -9, 1], [0.2, 9, 1], [-0.2, 9, 1]])
    points = np.concatenate([PYRAMID * [1, 1, 0.5] + [1, 0, -3], board])
    faces = [*PYRAMID_FACES, (5, 6, 7), (5, 7, 8)]
    subject = open_subject(mesh_scene(points, faces))
    view = Viewpoints(np.array([[0.0, 0, 9]]), np.array([[0.0, 0, -1]]), np.eye(3)[:1], np.eye(3)[1:2])
    found = survey(
        subject, view, stand(subject, orthographic=True).lens, Rays(side=256), ["curvature_entropy", "visible"]
    )
    assert found["visible"] == 6  # four sides and the board
    by_hand = deficits_by_hand(points, faces)
    hidden = [1, 2]  # at x = 0, behind the board
    assert found["curvature_entropy"] == pytest.approx(
        entropy([class_of(by_hand[k]) for k in range(9) if k not in hidden])
    )
