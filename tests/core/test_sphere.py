"""Geometry of the sphere of viewpoints."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracer.core import sphere

FINITE = st.floats(-1, 1)
DIRECTIONS = st.tuples(FINITE, FINITE, FINITE).filter(lambda v: np.linalg.norm(v) > 1e-2).map(sphere.normalised)


@pytest.mark.parametrize("level", [0, 1, 2, 3])
def test_an_icosphere_is_a_closed_sphere(level):
    points, triangles = sphere.icosphere(level)
    assert len(points) == 10 * 4**level + 2
    assert len(triangles) == 20 * 4**level
    assert np.linalg.norm(points, axis=1) == pytest.approx(1)
    areas = sphere.solid_angle(*points[triangles].transpose(1, 0, 2))
    assert np.all(areas > 0)
    assert areas.sum() == pytest.approx(4 * np.pi)
    assert len(np.unique(points.round(9), axis=0)) == len(points)
    beside = sphere.neighbours(triangles)
    assert sorted({len(each) for each in beside}) == ([5] if level == 0 else [5, 6])
    assert all(k in beside[other] for k in range(len(points)) for other in beside[k])


def test_the_survey_has_642_viewpoints():
    assert len(sphere.icosphere(3)[0]) == 642


def test_octants_cover_the_sphere_once():
    axes, triangles = sphere.octants()
    areas = sphere.solid_angle(*axes[triangles].transpose(1, 0, 2))
    assert areas == pytest.approx(np.full(8, np.pi / 2))


def test_a_split_octant_has_the_known_areas():
    axes, triangles = sphere.octants()
    points, parts = sphere.split(axes, triangles[:1])
    areas = sphere.solid_angle(*points[parts].transpose(1, 0, 2))
    assert areas == pytest.approx([0.339837] * 3 + [0.551286], abs=1e-6)


@settings(deadline=None)  # how long it takes depends on what else the machine does
@given(DIRECTIONS, DIRECTIONS)
def test_angles_are_those_of_the_cosine(a, b):
    assert np.cos(sphere.angle(a, b)) == pytest.approx(np.dot(a, b), abs=1e-9)
    if sphere.angle(a, b) < 3:
        half = sphere.middle(a, b)
        assert sphere.angle(a, half) == pytest.approx(sphere.angle(b, half), abs=1e-9)
        assert sphere.angle(a, half) == pytest.approx(sphere.angle(a, b) / 2, abs=1e-9)


@settings(deadline=None)  # how long it takes depends on what else the machine does
@given(DIRECTIONS, DIRECTIONS)
def test_a_frame_is_right_handed_and_upright(direction, up):
    right, upward = sphere.frame(direction, up)
    basis = np.stack([right, upward, -direction])
    assert basis @ basis.T == pytest.approx(np.eye(3), abs=1e-6)
    assert np.linalg.det(basis) == pytest.approx(1)
    if abs(np.dot(direction, up)) < 0.99:
        assert np.dot(upward, up) > 0


def test_a_spiral_is_even():
    points = sphere.evenly(1000)
    assert np.linalg.norm(points, axis=1) == pytest.approx(1)
    assert np.linalg.norm(points.mean(axis=0)) < 2e-3
    nearest = np.sort(np.linalg.norm(points[:, None] - points, axis=-1), axis=1)[:, 1]
    assert nearest.min() > 0.6 * nearest.max()


def test_a_direction_needs_a_length():
    with pytest.raises(ValueError, match="length"):
        sphere.normalised([[0, 0, 1], [0, 0, 0]])


def test_what_has_no_length_stays_where_that_is_allowed():
    assert np.array_equal(sphere.normalised_or_zero([[0, 0, 2], [0, 0, 0]]), [[0, 0, 1], [0, 0, 0]])
