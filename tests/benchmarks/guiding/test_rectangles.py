"""Direct light by places on rectangles that are chosen in three ways is the same, and that of ``path``."""

import mitsuba as mi
import numpy as np
import pytest

from benchmarks.guiding.rectangles import SPP, WAYS, Lights, direct_light, gains
from guiding.lights import scene_with_lights
from tracer.scene.view import open_scene


@pytest.fixture(scope="module")
def view():
    scene = scene_with_lights("area", "sphere", "point", "area", size=(12, 9))
    with open_scene(scene) as opened:
        yield opened


@pytest.mark.parametrize("way", WAYS)
def test_direct_light_is_that_of_path(view, way):
    lights = Lights.of(view.scene)
    assert (lights.count, lights.rectangle_count) == (4, 2)
    path = mi.load_dict({"type": "path", "max_depth": 2, "hide_emitters": True})
    expected = np.array(mi.render(view.scene, integrator=path, spp=4096, seed=1)).mean(axis=-1).ravel()
    found = direct_light(view, lights, way, 5, 1024)
    assert found.mean() == pytest.approx(expected.mean(), rel=0.005)
    assert np.allclose(found, expected, rtol=0.1, atol=0.01 * expected.max())


def test_gains_are_factors(view):
    found = gains(view, Lights.of(view.scene), 7)
    for way in WAYS[1:]:
        assert len(found.variance[way]) == len(SPP)
        assert min(found.variance[way]) > 0.2
        assert found.time[way] > 0
