"""Smoothed patches: corners that meet, and a linear change between them."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.radiosity.meshing import cell_corners, cut
from tracer.radiosity.patches import cell_of
from tracer.radiosity.smooth import Smooth, corner_numbers, corner_weights

T = mi.ScalarTransform4f
LIGHT = {"type": "constant"}


@pytest.mark.parametrize("cuts", [1, 2, 5])
def test_weights_of_corners_give_the_place_back(cuts):
    generator = np.random.default_rng(cuts)
    place = generator.random((2000, 2))
    place[place.sum(axis=1) > 1] = 1 - place[place.sum(axis=1) > 1]
    where = mi.Point2f(*place.T.astype(np.float32))
    n = dr.zeros(mi.UInt32, 2000) + cuts
    weights = np.stack([each.numpy() for each in corner_weights(where, n)], axis=-1)
    assert weights.min() > -1e-5
    assert weights.sum(axis=1) == pytest.approx(np.ones(2000), abs=1e-5)
    corners = cell_corners(cuts)[cell_of(where, n).numpy()]
    assert np.einsum("nk,nkd->nd", weights, corners) == pytest.approx(place, abs=1e-5)


def test_corners_of_a_square_meet_and_those_of_a_cube_do_not():
    square = cut(mi.load_dict({"type": "scene", "light": LIGHT, "s": {"type": "rectangle"}}), 0.75)
    sides = len(np.unique(corner_numbers(square)))
    # Two triangles cut in four along each edge: 5 x 5 corners.
    assert len(square) == 2 * 16
    assert sides == 25
    cube = cut(mi.load_dict({"type": "scene", "light": LIGHT, "c": {"type": "cube"}}))
    assert len(np.unique(corner_numbers(cube))) == 6 * 4


def test_a_round_shape_is_smooth_across_its_faces():
    ball = cut(mi.load_dict({"type": "scene", "light": LIGHT, "b": {"type": "sphere"}}), 0.5)
    numbers = corner_numbers(ball)
    assert len(np.unique(numbers)) < 0.8 * len(ball)


def test_an_even_change_is_shown_as_it_is():
    scene = mi.load_dict({"type": "scene", "light": LIGHT, "s": {"type": "rectangle"}})
    patches = cut(scene, 0.3)
    rising = np.pi * np.repeat(2 + patches.centres[:, :1], 3, axis=1)
    smooth = Smooth(patches, rising)
    x = np.linspace(-0.7, 0.7, 40)
    ray = mi.Ray3f(mi.Point3f(mi.Float(x.astype(np.float32)), 0.123, 1), mi.Vector3f(0, 0, -1))
    shown = np.array(smooth.at(scene.ray_intersect_preliminary(ray), ray))[0]
    assert shown == pytest.approx(2 + x, abs=0.01)
