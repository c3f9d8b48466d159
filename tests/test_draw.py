"""Drawing samples: recorded and traced, they are the same."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer import draw
from tracer.line import Line, Stretch, lane_pixels, line_of
from tracer.scene import open_scene


@pytest.mark.parametrize(("sensor", "known"), [("perspective", True), ("thinlens", True), ("thinlens", False)])
def test_recorded_samples_are_those_that_are_traced(sensor, known, monkeypatch):
    scene = mi.cornell_box()
    scene["sensor"]["film"] |= {"width": 8, "height": 8}
    scene["sensor"]["type"] = sensor
    if sensor == "thinlens":  # cannot be recorded by Mitsuba 3.9
        scene["sensor"] |= {"aperture_radius": 0.3, "focus_distance": 4.0}
    if not known:  # found out when it fails
        monkeypatch.setattr(draw, "HIDES_ARRAYS", ())
    sampler = mi.load_dict({"type": "owen_sobol"})
    scale = dr.opaque(mi.Float, 0.25)
    with open_scene(scene) as view:
        recorded = draw.Recorded(view, sampler)
        for spp in (1, 5, 64):
            counts = np.full(view.pixel_count, spp, np.uint32)
            seed = dr.opaque(mi.UInt32, spp)
            pixel, index = lane_pixels(Line(Stretch(0, counts, 2 * counts)).take(1 << 20))
            traced = draw.draw(view, sampler, seed, pixel, index, scale)
            found = recorded(seed, pixel, index, scale)
            assert len(found.values) == 3
            for a, b in zip([*found.values, *found.position], [*traced.values, *traced.position], strict=True):
                assert np.array_equal(a.numpy(), b.numpy())
            assert np.ptp(found.values[0].numpy()) > 0
        assert recorded.recordable == (sensor == "perspective" or known)
        recorded.close()


def drawn_rays(scene, spp=16):
    """Return the rays of every sample of a scene."""
    sampler = mi.load_dict({"type": "owen_sobol"})
    with open_scene(scene) as view:
        counts = np.full(view.pixel_count, spp, np.uint32)
        pixel, index = lane_pixels(line_of(counts).take(1 << 20))
        samples = draw.draw(view, sampler, mi.UInt32(1), pixel, index, mi.Float(0.25))
        return samples.rays.numpy()


def camera_at(depth):
    """Return a scene with a camera at z = 4 that sees nothing yet, and paths of at most ``depth`` edges."""
    camera = {"type": "perspective", "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0])}
    camera["film"] = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}}
    return {"type": "scene", "integrator": {"type": "path", "max_depth": depth}, "sensor": camera}


def test_a_path_that_leaves_the_scene_at_once_has_one_ray():
    assert np.all(drawn_rays(camera_at(8) | {"sky": {"type": "constant"}}) == 1)


def test_rays_of_a_path_that_is_reflected_once_into_the_sky():
    # To the plane, from there to the emitter, and a reflected one that leaves.
    plane = {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(100)}
    assert np.all(drawn_rays(camera_at(8) | {"plane": plane, "sky": {"type": "constant"}}) == 3)


def test_rays_between_two_mirrors_are_more_the_longer_the_path():
    mirror = {"type": "conductor", "material": "none"}
    T = mi.ScalarTransform4f
    front = {"type": "rectangle", "to_world": T().scale(100), "bsdf": mirror}
    back = {"type": "rectangle", "to_world": T().translate([0, 0, 5]).rotate([0, 1, 0], 180).scale(100), "bsdf": mirror}
    short, long = (drawn_rays(camera_at(depth) | {"a": front, "b": back}).mean() for depth in (3, 6))
    assert 1.5 * short < long
