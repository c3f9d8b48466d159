"""Vertices that a view sees, against what geometry says."""

import itertools

import mitsuba as mi
import numpy as np
import pytest

from tracer.core import sphere
from tracer.viewpoint import vertices
from tracer.viewpoint.item_buffer import Viewpoints, around, at
from tracer.viewpoint.lens import Orthographic, Perspective, WholeSphere
from tracer.viewpoint.surfaces import open_subject
from tracer.viewpoint.vertices import seen_vertices

from .conftest import mesh_scene


def seen_places(subject, viewpoints, lens):
    return [subject.mesh.places[found] for found in seen_vertices(subject, viewpoints, lens)]


def in_front(places, direction):
    """Return the corners of a box around the origin that are on a side which faces ``direction``."""
    return places[np.any(places * direction > 1e-9, axis=1)]


@pytest.mark.parametrize("lens", [Orthographic(2.0), Perspective(60)])
@pytest.mark.parametrize(("scale", "offset"), [(1.0, 0.0), (1e-4, 0.0), (1e4, 0.0), (1.0, 1e3)])
def test_corners_of_a_box_on_the_sides_that_face_the_eye(lens, scale, offset):
    sides = scale * np.array([0.5, 0.7, 0.3])
    place = mi.ScalarTransform4f().translate(3 * [offset]).scale((sides).tolist())
    subject = open_subject(mi.load_dict({"type": "scene", "box": {"type": "cube", "to_world": place}}))
    assert len(subject.mesh.places) == 8  # of the 24 that Mitsuba keeps
    lens = Orthographic(2 * scale) if isinstance(lens, Orthographic) else lens
    directions = sphere.evenly(30)
    views = around(np.full(3, offset), 6 * scale, directions)
    for found, direction in zip(seen_places(subject, views, lens), directions, strict=True):
        local = (subject.mesh.places - offset) / scale
        eye = direction * (1e9 if isinstance(lens, Orthographic) else 6)
        facing = np.any((np.sign(local) * eye > np.abs(local)), axis=1)  # on the eye's side of the plane of a side
        assert (found - offset) / scale == pytest.approx(local[facing], abs=1e-3)


def test_what_is_outside_the_image_or_behind_is_not_seen():
    points = np.array(
        [[0.0, 0, 0], [0.9, 0, 0], [0, 0.9, 0], [1.1, 0, 0], [0, 1.1, 0], [0, 0, 9], [1, 0, 9], [0, 1, 9]]
    )
    subject = open_subject(mesh_scene(points, [(0, 1, 2), (0, 3, 4), (5, 6, 7)]))
    down = around(np.zeros(3), 2, np.array([[0.0, 0, 1]]))
    expected = {tuple(place) for place in points[:3]}
    for lens in (Orthographic(1), Perspective(float(np.degrees(2 * np.arctan(0.5))))):
        assert {tuple(place) for place in seen_places(subject, down, lens)[0].round(3)} == expected
    everywhere = seen_places(subject, at(np.array([[-1.0, -1, 1]])), WholeSphere())[0]
    assert len(everywhere) == 8
    at_a_vertex = seen_places(subject, at(points[:1] * 1.0), WholeSphere())[0]
    assert len(at_a_vertex) == 7  # all but that


def test_what_is_no_mesh_hides():
    points = [[-1.0, 0, 0], [1, 0, 0], [0, 1, 0]]
    mesh = mesh_scene(points, [(0, 1, 2)]).shapes()[0]
    ball = {"type": "sphere", "center": [1, 0, 1], "radius": 0.5}
    subject = open_subject(mi.load_dict({"type": "scene", "mesh": mesh, "ball": ball}))
    above, below = seen_places(subject, around(np.zeros(3), 4, np.array([[0.0, 0, 1], [0, 0, -1]])), Orthographic(2))
    assert sorted(map(tuple, above)) == [(-1, 0, 0), (0, 1, 0)]
    assert len(below) == 3  # from behind, a face is seen as well


def test_wavefronts_change_nothing(triangles, monkeypatch):
    subject = open_subject(triangles)
    views = around(subject.centre, 4, sphere.evenly(7))
    whole = list(seen_vertices(subject, views, Perspective(40)))
    monkeypatch.setattr(vertices, "MOST_VERTICES", 17)
    again = list(seen_vertices(subject, views, Perspective(40)))
    assert len(again) == 7
    assert all(np.array_equal(*pair) for pair in itertools.zip_longest(whole, again))


def test_the_frame_of_a_view_that_is_turned(triangles):
    subject = open_subject(triangles)
    view = around(subject.centre, 4, sphere.normalised([[1.0, 2.0, 3.0]]))
    rolled = Viewpoints(view.eyes, view.forward, view.up, -view.right)
    assert np.array_equal(*(next(seen_vertices(subject, one, Perspective(40))) for one in (view, rolled)))
