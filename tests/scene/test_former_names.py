"""Names of earlier versions: unknown to this one, which knows what is offered instead."""

import re

import mitsuba as mi
import numpy as np
import pytest

from tracer.scene.former_names import PARAMETERS, PLUGINS, former_parameter, former_plugin, linear_colour
from tracer.scene.load_errors import plugin_names


def test_what_is_offered_exists_and_what_is_replaced_does_not():
    known = plugin_names()
    kinds = set(known.values())
    for kind, plugins in PLUGINS.items():
        assert kind in kinds
        for name, instead in plugins.items():
            assert known.get(name) != kind, name
            assert set(re.findall(r"'(\w+)'", instead)) <= set(known), name


KNOWN = {
    "film": {"type": "hdrfilm", "sample_border": True},
    "texture": {"type": "bitmap", "bitmap": mi.Bitmap(np.ones((2, 2, 3), np.float32)), "raw": True},
    "shape": {"type": "cube", "face_normals": True},
    "bsdf": {"type": "conductor", "eta": 1.5, "k": 1.0},
    "medium": {"type": "homogeneous", "sigma_t": 1.0, "albedo": 0.5},
}
"""One plugin of each kind with all parameters that are offered."""


@pytest.mark.parametrize("kind", PARAMETERS)
def test_parameters_that_are_offered_exist(kind):
    offered = {name for instead in PARAMETERS[kind].values() for name in re.findall(r"'(\w+)'", instead)}
    assert offered <= set(KNOWN.get(kind, {}))
    if kind in KNOWN:
        mi.load_dict(KNOWN[kind])


def test_kinds_are_kept_apart():
    assert former_plugin("bsdf", "phong") == former_plugin(None, "phong") is not None
    assert former_plugin("integrator", "phong") is None
    assert former_plugin("nothing", "phong") is None
    assert former_plugin(None, "path") is None


@pytest.mark.parametrize("name", ["strict_normals", "strictNormals"])
def test_parameters_are_known_as_both_versions_write_them(name):
    assert former_parameter("integrator", name) == "leave it out"
    assert former_parameter("bsdf", name) is None


def test_colours_of_a_screen_become_linear():
    # IEC 61966-2-1: 128 of 255 is 0.215861 linear
    assert linear_colour("#ff8000") == "1, 0.2159, 0"
    for other in ("#ff80", "red", "#ff80zz", "0.5"):
        assert linear_colour(other) is None
