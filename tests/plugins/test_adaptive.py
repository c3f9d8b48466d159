"""The integrator, as plain Mitsuba sees it."""

import mitsuba as mi
import numpy as np
import pytest

import tracer
from conftest import SENSOR


def test_renders_from_xml_under_mi_render(scene_file):
    body = f'<integrator type="adaptive"><integrator type="path"/></integrator>{SENSOR}<emitter type="constant"/>'
    scene = mi.load_file(str(scene_file(body)))
    image = np.array(mi.render(scene, spp=8))
    assert image.shape == (8, 12, 3)
    assert image == pytest.approx(np.ones((8, 12, 3)), rel=1e-5)
    assert scene.integrator().result.samples.sum() == 8 * 8 * 12


def test_gives_the_picture_of_render(cornell):
    nested = {"type": "path", "max_depth": 3}
    scene = cornell() | {"integrator": {"type": "adaptive", "nested": nested, "criterion": "variance", "min_spp": 3}}
    found = np.array(mi.render(mi.load_dict(scene), spp=16, seed=4))
    options = {"integrator": nested, "criterion": "variance", "min_spp": 3}
    expected = tracer.render(mi.load_dict(cornell()), spp=16, seed=4, **options).image
    assert found == pytest.approx(expected, rel=1e-4, abs=1e-5)


def test_render_takes_the_settings_of_a_scenes_integrator(cornell):
    scene = cornell() | {"integrator": {"type": "adaptive", "spp": 8, "criterion": "uniform"}}
    assert np.all(tracer.render(scene).samples == 8)
    assert np.all(tracer.render(scene, spp=4).samples == 4)


def test_sample_count_of_the_sampler_is_the_default_budget(cornell):
    scene = cornell() | {"integrator": {"type": "adaptive"}}
    scene["sensor"]["sampler"] = {"type": "independent", "sample_count": 5}
    scene = mi.load_dict(scene)
    mi.render(scene)
    assert scene.integrator().result.samples.sum() == 5 * 24 * 16


def test_the_nested_integrators_channels_are_kept(cornell):
    aov = {"type": "aov", "aovs": "dd.y:depth", "inner": {"type": "path"}}
    scene = mi.load_dict(cornell(filter_name="box") | {"integrator": {"type": "adaptive", "nested": aov}})
    image = np.array(mi.render(scene, spp=16))
    assert image.shape[-1] == 3 + len(mi.load_dict(aov).aov_names())
    assert scene.integrator().result.channels[-1] == "dd.y.T"


def test_survives_a_change_of_variant_and_back(cornell):
    try:
        tracer.activate("llvm_ad_mono")
        scene = mi.load_dict(cornell() | {"integrator": {"type": "adaptive"}})
        assert np.array(mi.render(scene, spp=8)).shape == (16, 24, 1)
    finally:
        tracer.activate("llvm_ad_rgb")
    assert tracer.render(cornell(), spp=8).image.shape == (16, 24, 3)


def test_prints_itself():
    assert "min_spp = 3" in str(mi.load_dict({"type": "adaptive", "min_spp": 3}))


@pytest.mark.parametrize("pixel_format", ["rgb", "rgba", "luminance", "xyz"])
def test_the_picture_is_left_in_the_film(cornell, pixel_format):
    scene = mi.load_dict(cornell(pixel_format=pixel_format) | {"integrator": {"type": "adaptive"}})
    image = np.array(scene.integrator().render(scene, spp=8))
    assert np.array(scene.sensors()[0].film().develop()) == pytest.approx(image, rel=1e-4, abs=1e-5)


def test_mitsubas_python_integrators_can_be_nested(cornell):
    names = ("prb", "path")
    images = [tracer.render(cornell(), spp=256, integrator={"type": name, "max_depth": 3}).image for name in names]
    assert images[0].mean() == pytest.approx(images[1].mean(), rel=0.02)


def test_largest_seed(cornell):
    assert tracer.render(cornell(), spp=16, seed=2**32 - 1).report.complete
