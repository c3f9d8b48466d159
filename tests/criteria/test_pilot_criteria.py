"""What criteria make of the things that pilot rays hit."""

import mitsuba as mi
import numpy as np
import pytest

from tracer import criteria
from tracer.complexity import pilot
from tracer.scene.view import open_scene

from .made_up import evidence_of, light, statistics_of

T = mi.ScalarTransform4f


@pytest.fixture
def half_seen():
    """Return what is seen of a rectangle over the left half of 8 x 8 pixels, which are one block."""
    film = {"type": "hdrfilm", "width": 8, "height": 8}
    sensor = {"type": "orthographic", "to_world": T().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]), "film": film}
    shape = {"type": "rectangle", "to_world": T().translate([-0.5, 0, 0]) @ T().scale([0.5, 1, 1])}
    with open_scene({"type": "scene", "integrator": {"type": "path"}, "sensor": sensor, "shape": shape}) as view:
        yield pilot.measure_complexity(view, mi.load_dict({"type": "owen_sobol"}), 0, rays=4, block=8)


EXPECTED = {
    "shape_entropy": 1 / 8,  # one bit of log2 256
    "face_entropy": 1.5 / 8,
    "shape_gini": 0.5,
    "face_gini": 1 - 1 / 4 - 2 / 16,  # it has two triangles
    "viewpoint_complexity": (1 + 0.5) / 2,  # the one shape is visible, and covers half
    "geometry_contrast": 1 / 8,  # ln 2 of ln 256
}


@pytest.mark.parametrize("name", EXPECTED)
def test_importance_is_the_measure_over_a_floor(half_seen, name):
    evidence = evidence_of(statistics_of(light(2, 8, 8), name), look=lambda: half_seen)
    expected = np.full((8, 8), np.sqrt(np.sqrt(EXPECTED[name]) + 0.3))
    assert criteria.get(name).importance(evidence) == pytest.approx(expected, abs=1e-3)
