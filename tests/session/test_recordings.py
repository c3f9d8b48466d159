"""A recording serves every render of a scene until something about the scene changes, and no longer than the scene."""

import gc

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

import tracer
from guiding.lights import scene_with_lights
from tracer.sampling.samples import Recorded, make_sampler
from tracer.session import recordings


@pytest.fixture(autouse=True)
def none_kept():
    recordings.let_go_of_all()
    yield
    recordings.let_go_of_all()


def picture(scene, **given):
    return tracer.render(scene, **{"spp": 16, **given}).image


def recording_counts():
    return [kept.recorded.record.n_recordings for kept in recordings.kept]


def test_a_second_render_records_nothing_and_is_the_same(cornell):
    scene = mi.load_dict(cornell())
    first, other = picture(scene), picture(scene, seed=1, criterion="uniform")
    assert len(recording_counts()) == 1
    before = recording_counts()
    assert np.array_equal(picture(scene), first)
    assert np.array_equal(picture(scene, seed=1, criterion="uniform"), other)
    assert recording_counts() == before


def test_sizes_moments_and_integrators_have_their_own(cornell):
    scene = mi.load_dict(cornell())
    for given in ({}, {"size": 12}, {"criterion": "luxcore"}, {"integrator": "direct"}, {"size": 13}):
        assert np.array_equal(picture(scene, **given), picture(mi.load_dict(cornell()), **given))
        assert 1 <= len(recordings.kept) <= recordings.MOST_KEPT


def test_pictures_of_two_sizes_do_not_push_out_one_another(cornell):
    scene = mi.load_dict(cornell())
    for size in (12, 13, 12, 13):
        picture(scene, size=size)
    assert recording_counts() == [1, 1]


HEAVY = {
    "type": "scene",
    "integrator": {"type": "volpath", "max_depth": 8},
    "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 16, "height": 12}},
    "smoke": {
        "type": "sphere",
        "center": [0, 0, 3],
        "bsdf": {"type": "null"},
        "interior": {
            "type": "homogeneous",
            "albedo": 0.8,
            "sigma_t": 1.0,
            "phase": {"type": "hg", "g": 0.2},
        },
    },
    "glass": {"type": "sphere", "center": [0.5, 0, 4], "radius": 0.5, "bsdf": {"type": "dielectric"}},
    "paint": {
        "type": "cube",
        "to_world": mi.ScalarTransform4f().translate([-1, 0, 5]),
        "bsdf": {"type": "principled", "clearcoat": 0.5, "spec_tint": 0.4, "roughness": 0.3},
    },
    "picture": {
        "type": "rectangle",
        "to_world": mi.ScalarTransform4f().translate([0, 0, 6]).scale(4).rotate([0, 1, 0], 180),
        "bsdf": {"type": "diffuse", "reflectance": {"type": "bitmap", "data": mi.TensorXf(np.ones((4, 4, 3)) * 0.5)}},
    },
    "sky": {"type": "constant"},
    "lamp": {"type": "point", "position": [0, 2, 0], "intensity": 3.0},
}


@pytest.mark.slow
def test_every_parameter_that_changes_is_seen():
    """Numbers that are no arrays are compiled into a recording, and some arrays are hidden from Dr.Jit, too."""
    scene = mi.load_dict(HEAVY)
    parameters = mi.traverse(scene)
    names = [name for name in parameters.keys() if changed(parameters[name]) is not None]  # noqa: SIM118
    assert len(names) > 30
    seen, last = 0, picture(scene, spp=4)
    for name in names:
        parameters[name] = changed(parameters[name])
        parameters.update()
        kept = picture(scene, spp=4)
        assert len(recordings.kept) == 1  # that of the former value is gone
        recordings.let_go_of_all()
        anew = picture(scene, spp=4)
        assert np.array_equal(kept, anew), name
        seen += not np.array_equal(anew, last)
        last = anew
    assert seen > 12


def changed(value):
    """Return another value of a parameter, or None for those that this test leaves alone, such as sizes."""
    kind = type(value)
    if kind in (float, mi.Float, mi.Color3f, mi.Point3f, mi.TensorXf):
        return kind(value * 0.9)
    return kind(value @ kind().translate([0.01, 0, 0])) if kind is mi.AffineTransform4f else None


def test_a_kept_recording_does_not_outlive_its_scene(cornell):
    scene = mi.load_dict(cornell())
    picture(scene)
    gc.collect()
    assert len(recordings.kept) == 1
    del scene
    gc.collect()
    assert recordings.kept == []


def collect_within_a_recording():
    """Collect garbage while Dr.Jit records something else, as Python may do at any time."""

    @dr.freeze
    def recorded(numbers):
        gc.collect()
        return numbers + 1

    dr.eval(recorded(mi.Float(1, 2)))
    recorded.clear()


def collect_within_a_loop():
    dr.eval(
        dr.while_loop((mi.UInt32(0, 1),), lambda number: number < 3, lambda number: (gc.collect() * 0 + number + 1,))
    )


@pytest.mark.parametrize("collect", [collect_within_a_recording, collect_within_a_loop])
def test_nothing_is_let_go_of_while_something_else_is_traced(cornell, collect):
    """Dr.Jit would end the process."""
    gc.disable()  # else it may come too early
    try:
        picture(mi.load_dict(cornell()))
        collect()
        assert len(recordings.kept) == 1
    finally:
        gc.enable()
    gc.collect()
    assert recordings.kept == []


def test_a_scene_that_is_opened_for_one_render_is_not_kept(cornell, monkeypatch):
    monkeypatch.setattr(recordings, "parameters_of", None)  # nor are its parameters looked at
    picture(cornell())
    assert recordings.kept == []


def test_a_failed_recording_is_not_kept(cornell, monkeypatch):
    scene = mi.load_dict(cornell())
    with tracer.scene.view.open_scene(scene) as view:
        taken = recordings.take(view, None, lambda: Recorded(view, make_sampler()))
        taken.recorded.recordable = False
        recordings.give_back(taken)
    assert recordings.kept == []
    assert recordings.in_use == 0


def test_what_training_records_serves_again_and_is_let_go():
    """Twenty lights, so that it is worth a look; the second render of the scene traces neither training nor drawing."""
    scene = scene_with_lights("sphere", *["far lamp"] * 19)
    first = tracer.render(scene, spp=512, size=32, guide=True, criterion="uniform")
    assert len(recordings.kept) == 2
    made = [id(recording.recorded) for recording in recordings.kept]
    second = tracer.render(scene, spp=512, size=32, guide=True, criterion="uniform")
    assert sorted(made) == sorted(id(recording.recorded) for recording in recordings.kept)
    assert np.array_equal(first.image, second.image)
    del scene
    gc.collect()
    recordings.let_go_of_unused()
    assert recordings.kept == []
