"""Directions in spherical triangles as the cosine is: areas, places and density."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from tracer.radiosity.cosine_triangle import cosine_in_triangle, parts_of, table_of
from tracer.radiosity.triangle_hierarchy import pyramid

TABLE = pyramid(4)


def directions(triangle, count, seed=0):
    """Return random directions (count, 3) in one triangle of the table."""
    generator = np.random.default_rng(seed)
    u, v = (mi.Float(generator.random(count).astype(np.float32)) for _ in range(2))
    which = dr.zeros(mi.UInt32, count) + triangle
    return np.array(cosine_in_triangle(table_of(4), which, u, v), np.float64).T


def inside(corners, toward, slack):
    """Return whether directions are in a triangle."""
    planes = np.cross(corners, np.roll(corners, -1, axis=0))
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    return (toward @ planes.T > -slack).all(axis=1)


def test_the_two_parts_have_the_projected_solid_angle():
    assert parts_of(TABLE.corners)[:, :, 6].sum(axis=1) == pytest.approx(TABLE.projected, abs=1e-14)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, len(TABLE.projected) - 1))
def test_directions_are_in_their_triangle(triangle):
    toward = directions(triangle, 4096)
    assert np.linalg.norm(toward, axis=1) == pytest.approx(np.ones(4096), abs=1e-6)
    assert inside(TABLE.corners[triangle], toward, 2e-6).all()


@pytest.mark.parametrize("triangle", [0, 3, 5, 6, 7, 30, 44, 100, 300])
def test_density_is_the_cosine(triangle):
    """The parts of a triangle, down to the deepest level, are hit as often as their projected solid angles are."""
    level = int(np.searchsorted(TABLE.first, triangle, side="right")) - 1
    parts = np.array([triangle])
    for deeper in range(level, min(level + 2, 4)):
        parts = TABLE.children(parts, deeper).ravel()
    count = 200_000
    toward = directions(triangle, count)
    hits = np.array([inside(TABLE.corners[part], toward, 0).sum() for part in parts])
    expected = TABLE.projected[parts] / TABLE.projected[parts].sum() * count
    assert abs(hits.sum() - count) < 100
    # Nine triangles with a false-alarm rate of 1e-4 each.
    assert stats.chisquare(hits * (count / hits.sum()), expected).pvalue > 1e-4
