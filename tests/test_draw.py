"""Drawing samples: recorded and traced, they are the same."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer import draw
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
            pixel, index = draw.lane_pixels(draw.Line(counts, counts).take(1 << 20))
            traced = draw.draw(view, sampler, seed, pixel, index, scale)
            found = recorded(seed, pixel, index, scale)
            assert len(found.values) == 3
            for a, b in zip([*found.values, *found.position], [*traced.values, *traced.position], strict=True):
                assert np.array_equal(a.numpy(), b.numpy())
            assert np.ptp(found.values[0].numpy()) > 0
        assert recorded.recordable == (sensor == "perspective")
        recorded.close()
