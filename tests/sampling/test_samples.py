"""Drawing samples: recorded and traced, they are the same."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.sampling import samples
from tracer.sampling.wavefront import Line, Stretch, lane_pixels, line_of
from tracer.scene.view import open_scene


@pytest.mark.parametrize(("sensor", "known"), [("perspective", True), ("thinlens", True), ("thinlens", False)])
def test_recorded_samples_are_those_that_are_traced(sensor, known, monkeypatch):
    scene = mi.cornell_box()
    scene["sensor"]["film"] |= {"width": 8, "height": 8}
    scene["sensor"]["type"] = sensor
    if sensor == "thinlens":  # cannot be recorded by Mitsuba 3.9
        scene["sensor"] |= {"aperture_radius": 0.3, "focus_distance": 4.0}
    if not known:  # found out when it fails
        monkeypatch.setattr(samples, "HIDES_ARRAYS", ())
    sampler = mi.load_dict({"type": "owen_sobol"})
    scale = dr.opaque(mi.Float, 0.25)
    with open_scene(scene) as view:
        recorded = samples.Recorded(view, sampler)
        for spp in (1, 5, 64):
            counts = np.full(view.pixel_count, spp, np.uint32)
            seed = dr.opaque(mi.UInt32, spp)
            pixel, index = lane_pixels(Line(Stretch(0, counts, 2 * counts)).take(1 << 20))
            traced = samples.draw(view, sampler, seed, pixel, index, scale)
            found = recorded(seed, pixel, index, scale)
            assert len(found.values) == 3
            for a, b in zip([*found.values, *found.position], [*traced.values, *traced.position], strict=True):
                assert np.array_equal(a.numpy(), b.numpy())
            assert np.ptp(found.values[0].numpy()) > 0
        assert recorded.recordable == (sensor == "perspective" or known)
        recorded.close()


def first_rays(scene, scale=1.0, spp=64):
    """Return the camera's rays of the samples of one pixel, and those that ``camera_rays`` makes of them."""
    sampler = mi.load_dict({"type": "owen_sobol"})
    with open_scene(scene) as view:
        index = dr.arange(mi.UInt32, spp)
        sampler.seed_samples(mi.UInt32(1), 0 * index, index)
        whole = samples.camera_ray(view, sampler, 0 * index, 0 * index)[0]
        sampler.seed_samples(mi.UInt32(1), 0 * index, index)
        return whole, samples.camera_rays(view, sampler, 0 * index, mi.Float(scale))[0]


def test_samples_are_spread_over_the_time_that_a_shutter_is_open():
    """64 of them, one in each 64th of it."""
    scene = camera_at(3)
    scene["sensor"] |= {"shutter_open": 2.0, "shutter_close": 4.0}
    time = first_rays(scene)[0].time.numpy()
    assert np.array_equal(np.sort(np.floor((time - 2) * 32)), np.arange(64))


def test_differentials_are_as_wide_as_samples_are_apart():
    """Of 16 samples a pixel a quarter of it."""
    whole, scaled = first_rays(camera_at(3), scale=16**-0.5)
    apart = np.array(whole.d_x) - np.array(whole.d)
    assert np.abs(apart).max() > 1e-3
    assert np.array(scaled.d_x) - np.array(scaled.d) == pytest.approx(apart / 4, abs=1e-6)


def test_a_camera_in_a_medium_sees_it():
    """Of a lamp behind a medium that absorbs, 4 away: exp(-0.25 x 4) of its radiance."""
    scene = camera_at(8) | {"integrator": {"type": "volpath", "max_depth": 8}}
    fog = mi.load_dict({"type": "homogeneous", "sigma_t": 0.25, "albedo": 0.0})
    scene["sensor"] |= {"fov": 1.0, "fog": fog}
    lamp = {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}
    large = mi.ScalarTransform4f().scale(9)
    scene["lamp"] = {"type": "rectangle", "to_world": large, "emitter": lamp, "exterior": fog}
    with open_scene(scene) as view:
        sampler = mi.load_dict({"type": "owen_sobol"})
        index = dr.arange(mi.UInt32, 4096)
        found = samples.draw(view, sampler, mi.UInt32(1), 0 * index, index, mi.Float(1)).values[0].numpy()
    # A path gets through or does not: standard error 0.5 / 64; four of them are exceeded once in 16 000 seeds.
    assert found.mean() == pytest.approx(np.exp(-1), abs=4 * 0.5 / 64)


def drawn_vertices(scene, spp=16):
    """Return the vertices of the path of every sample of a scene."""
    sampler = mi.load_dict({"type": "owen_sobol"})
    with open_scene(scene) as view:
        counts = np.full(view.pixel_count, spp, np.uint32)
        pixel, index = lane_pixels(line_of(counts).take(1 << 20))
        drawn = samples.draw(view, sampler, mi.UInt32(1), pixel, index, mi.Float(0.25))
        return drawn.vertices.numpy()


def camera_at(depth):
    """Return a scene with a camera at z = 4 that sees nothing yet, and paths of at most ``depth`` edges."""
    camera = {"type": "perspective", "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0])}
    camera["film"] = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}}
    return {"type": "scene", "integrator": {"type": "path", "max_depth": depth}, "sensor": camera}


def test_a_path_that_leaves_the_scene_at_once_has_one_vertex():
    assert np.all(drawn_vertices(camera_at(8) | {"sky": {"type": "constant"}}) == 1)


def test_a_path_that_is_reflected_once_into_the_sky_has_two_vertices():
    plane = {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(100)}
    assert np.all(drawn_vertices(camera_at(8) | {"plane": plane, "sky": {"type": "constant"}}) == 2)


def test_vertices_between_two_mirrors_are_more_the_longer_the_path():
    mirror = {"type": "conductor", "material": "none"}
    T = mi.ScalarTransform4f
    front = {"type": "rectangle", "to_world": T().scale(100), "bsdf": mirror}
    back = {"type": "rectangle", "to_world": T().translate([0, 0, 5]).rotate([0, 1, 0], 180).scale(100), "bsdf": mirror}
    short, long = (drawn_vertices(camera_at(depth) | {"a": front, "b": back}).mean() for depth in (3, 6))
    assert 1.5 * short < long
