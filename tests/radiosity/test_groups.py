"""Groups of neighbours: all points in one, close and alike, and frames that agree."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracer.radiosity.groups import ALIKE, Points, alone, neighbours

from .scenery import POINTS, plane


def scattered(count, seed, turned=True):
    generator = np.random.default_rng(seed)
    normals = generator.normal(size=(count, 3)) if turned else np.tile([0.0, 0.0, 1.0], (count, 1))
    return Points(generator.random((count, 3)), normals / np.linalg.norm(normals, axis=1, keepdims=True))


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 400), st.integers(1, 40), st.integers(0, 10**6))
def test_every_point_is_in_one_group_whose_normals_are_alike(count, most, seed):
    points = scattered(count, seed)
    groups = neighbours(points, most)
    assert np.sort(groups.members).tolist() == list(range(count))
    sizes = np.diff(groups.first)
    assert sizes.sum() == count
    assert count == 0 or 1 <= sizes.min() <= sizes.max() <= most
    for group in range(len(groups)):
        some = groups.members[groups.first[group] : groups.first[group + 1]]
        assert (points.normals[some] @ groups.normals[group]).min() > ALIKE - 1e-6
        assert (groups.group_of[some] == group).all()


def test_groups_of_a_plane_are_full_and_close():
    groups = neighbours(plane(64), 256)
    assert np.diff(groups.first).tolist() == [256] * 16
    places = groups.points.places[groups.members].reshape(16, 256, 3)
    assert np.ptp(places, axis=1).max() < 0.3


def test_points_that_are_one_place_are_halved_all_the_same():
    points = Points(np.zeros((100, 3)), np.tile([0.0, 0.0, 1.0], (100, 1)))
    assert np.diff(neighbours(points, 30).first).max() <= 30


def test_opposite_normals_are_apart():
    points = Points(np.zeros((2, 3)), np.array([[0.0, 0, 1], [0.0, 0, -1]]))
    assert len(neighbours(points, 10)) == 2


def test_members_are_chosen_alike():
    groups = neighbours(plane(8), 16)
    count = 1 << 16
    found = groups.member(dr.zeros(mi.UInt32, count) + 2, dr.arange(mi.UInt32, count)).numpy()
    times = np.bincount(found, minlength=64)
    assert set(np.flatnonzero(times)) == set(groups.members[32:48])
    assert times[times > 0] == pytest.approx(np.full(16, count / 16), rel=0.06)


def test_rays_leave_along_their_own_normal_and_frames_of_a_group_agree():
    groups = alone(POINTS)
    ray = groups.leave(dr.arange(mi.UInt32, 7), mi.Vector3f(0.6, 0.0, 0.8))
    toward = np.array(ray.d, np.float64).T
    assert (toward * POINTS.normals).sum(axis=1) == pytest.approx(np.full(7, 0.8), abs=1e-6)
    assert np.abs(np.array(ray.o).T - POINTS.places).max() < 1e-2
    tilted = np.array([[0.0, 0, 1], [0.1, 0, 1], [0, 0.1, 1]])
    normals = tilted / np.linalg.norm(tilted, axis=1, keepdims=True)
    together = neighbours(Points(np.zeros((3, 3)), normals), 10)
    assert len(together) == 1
    toward = np.array(together.leave(dr.arange(mi.UInt32, 3), mi.Vector3f(0.6, 0.0, 0.8)).d).T
    assert (toward @ toward.T).min() > 0.99
