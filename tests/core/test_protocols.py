"""Mitsuba's own objects are what the protocols say."""

import mitsuba as mi
import pytest

from tracer.core import protocols


@pytest.mark.parametrize("name", ["Scene", "Sensor", "Sampler", "Film", "Integrator", "Shape", "Emitter"])
def test_objects_of_mitsuba_have_all_methods(cornell, name):
    scene = mi.load_dict(cornell())
    sensor = scene.sensors()[0]
    objects = {
        "Scene": scene,
        "Sensor": sensor,
        "Sampler": sensor.sampler(),
        "Film": sensor.film(),
        "Integrator": scene.integrator(),
        "Shape": scene.shapes()[0],
        "Emitter": scene.emitters()[0],
    }
    protocol = getattr(protocols, name)
    methods = [method for method in dir(protocol) if callable(getattr(protocol, method)) and method[0] != "_"]
    assert methods
    assert all(callable(getattr(objects[name], method, None)) for method in methods)
