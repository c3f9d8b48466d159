"""An integrator that must know the whole scene is told of it before its first sample."""

import mitsuba as mi

import tracer
from conftest import small_scene
from tracer.scene.preparation import prepare_scene
from tracer.scene.view import open_scene


def test_an_integrator_prepares_for_the_scene_before_samples_are_drawn():
    tracer.activate()
    prepared = []

    class Preparing(mi.SamplingIntegrator):
        def prepare_scene(self, scene):
            prepared.append(scene)

        def sample(self, scene, sampler, ray, medium=None, active=True):
            assert prepared == [scene]
            return mi.Spectrum(0.5), mi.Bool(True), []

    scene = mi.load_dict(small_scene((4, 4)))
    with open_scene(scene, integrator=Preparing(mi.Properties("preparing"))):
        assert prepared == [scene]
    prepared.clear()
    result = tracer.render(scene, integrator=Preparing(mi.Properties("preparing")), spp=2)
    assert result.report.complete
    assert prepared == [scene]


def test_other_integrators_are_left_alone():
    tracer.activate()
    prepare_scene(mi.load_dict({"type": "path"}), None)
