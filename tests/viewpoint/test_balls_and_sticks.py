"""Balls and sticks as shapes, against rays at known places."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.core.device import upload
from tracer.viewpoint.balls_and_sticks import faces_of_ball, scene_of


def hit_by(scene, places):
    """Return (distance, shape, primitive) of what rays along -z from z = 9 above places (N, 3) hit."""
    origin = mi.Point3f(upload(mi.Float, places[:, 0]), upload(mi.Float, places[:, 1]), mi.Float(9.0))
    hit = scene.ray_intersect_preliminary(mi.Ray3f(origin, mi.Vector3f(0, 0, -1)))
    return hit.t.numpy(), hit.shape, hit.prim_index.numpy()


def test_primitives_are_balls_and_then_halves_of_sticks():
    generator = np.random.default_rng(0)
    positions = np.column_stack([np.arange(60) % 8 * 2.0, np.arange(60) // 8 * 2.0, generator.random(60)])
    bonds = np.stack([np.arange(59), np.arange(1, 60)], axis=1)[np.arange(1, 60) % 8 > 0]
    scene = scene_of(positions, np.full(60, 0.5), bonds, 0.14)
    assert [shape.is_mesh() for shape in scene.shapes()] == [True, False]
    distance, _, face = hit_by(scene, positions)
    assert distance == pytest.approx(8.5 - positions[:, 2], abs=0.01)
    assert (face // faces_of_ball(60)).tolist() == list(range(60))
    for half, share in enumerate((0.4, 0.6)):
        places = positions[bonds[:, 0]] * (1 - share) + positions[bonds[:, 1]] * share
        distance, shape, segment = hit_by(scene, places)
        assert set(shape) == {scene.shapes()[1]}
        assert segment.tolist() == (2 * np.arange(len(bonds)) + half).tolist()
        slope = (positions[bonds[:, 1], 2] - positions[bonds[:, 0], 2]) / 2
        assert distance == pytest.approx(9 - places[:, 2] - 0.14 * np.sqrt(1 + slope**2), abs=1e-4)
