"""Complexity of parts of a view."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

from tracer.core import sphere
from tracer.viewpoint.item_buffer import around
from tracer.viewpoint.lens import Orthographic
from tracer.viewpoint.regions import corners, look_through_blocks, look_through_triangles, uniform_in_triangle
from tracer.viewpoint.surfaces import open_subject

AXES, OCTANTS = sphere.octants()


def drawn(triangle, count):
    """Return ``count`` directions in a triangle (3, 3)."""
    generator = np.random.default_rng(5)
    u, v = (mi.Float(generator.random(count).astype(np.float32)) for _ in range(2))
    number = dr.zeros(mi.UInt32, count)
    return np.array(uniform_in_triangle(corners(np.asarray(triangle)[None], number), u, v)).T.astype(float)


@pytest.mark.parametrize(
    "triangle",
    [AXES[OCTANTS[0]], AXES[OCTANTS[7]], sphere.normalised([[0, 0, 1], [0.3, 0, 1], [0.1, 0.2, 1.0]])],
)
def test_directions_are_uniform_in_a_triangle(triangle):
    points, parts = sphere.split(*sphere.split(triangle, np.array([[0, 1, 2]])))
    areas = sphere.solid_angle(*points[parts].transpose(1, 0, 2))
    directions = drawn(triangle, 20000)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(1, abs=1e-5)
    a, b, c = points[parts].transpose(1, 0, 2)
    sides = np.stack([np.cross(*pair) @ directions.T for pair in ((a, b), (b, c), (c, a))])
    inside = sides.min(axis=0)  # of the 16 parts, the one whose planes all have it on their inner side
    which = inside.argmax(axis=0)
    assert inside.max(axis=0).min() > -1e-4
    counts = np.bincount(which, minlength=16)
    # False alarms: 1 in 1000 for all three triangles.
    assert stats.chisquare(counts, 20000 * areas / areas.sum()).pvalue > 0.001 / 3


def test_an_octant_that_sees_one_side_is_simple(quads):
    subject = open_subject(quads, "shape")
    inside = np.zeros((8, 3))
    found = look_through_triangles(subject, inside, AXES[OCTANTS], 4000)
    # From the middle of a cube an octant sees three sides, a third each.
    assert found.distinct == pytest.approx(np.full(8, 3))
    assert found.entropy == pytest.approx(np.full(8, np.log2(3)), abs=0.01)
    assert found.gini == pytest.approx(np.full(8, 2 / 3), abs=0.01)
    assert found.viewpoint_complexity == pytest.approx(np.full(8, 0.5 + 1))
    away = look_through_triangles(subject, np.full((8, 3), [0.0, 0.0, 9.0]), AXES[OCTANTS], 500)
    assert np.sort(away.distinct)[:4].tolist() == [1, 1, 1, 1]
    assert np.sort(away.entropy)[:4].tolist() == [0, 0, 0, 0]


def test_triangles_of_different_eyes_in_one_go(quads):
    subject = open_subject(quads, "shape")
    eyes = np.array([[0, 0, 0], [0, 0, 9.0]])
    up = np.repeat(AXES[OCTANTS[:1]], 2, axis=0)
    found = look_through_triangles(subject, eyes, up, 500)
    assert found.hit[0].all()
    assert found.hit[1].mean() < 0.1


def test_blocks_of_an_image_by_brute_force(triangles):
    subject = open_subject(triangles)
    view = around(subject.centre, 3, sphere.normalised([[1.0, 2.0, 3.0]]))
    found = look_through_blocks(subject, view, Orthographic(1), 4, 4, 16)
    whole = look_through_blocks(subject, view, Orthographic(1), 1, 1, 64)
    assert found.entropy.shape == (4, 4)
    assert found.hit.sum() == whole.hit.sum()
    empty = ~found.hit.any(axis=-1)
    assert np.all(found.entropy[empty] == 0)
    assert found.entropy.max() > 1
    counts = 1 / found.same  # each surface of a block adds up to 1
    assert counts.sum(axis=-1) == pytest.approx(found.distinct)
    wide = look_through_blocks(subject, view, Orthographic(1), 4, 2, 16)
    assert wide.entropy.shape == (2, 4)
