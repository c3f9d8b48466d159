"""With a constant map the adaptive integrator gives the picture of ``mi.render``, whatever the scene."""

import subprocess
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

import tracer
from conformance.cases import cases, mitsuba_picture, name, scene

SPP = 16


def assert_same(case, *, tolerance=1e-4):
    # One scene for both: the order of emitters, which is another at every loading, decides which a sample chooses.
    loaded = mi.load_dict(scene(**case, sample_count=SPP))
    expected = np.array(mitsuba_picture(loaded, 3, SPP))
    result = tracer.render(loaded, spp=SPP, seed=3, criterion="uniform")
    assert result.image.shape == expected.shape
    assert result.image == pytest.approx(expected, rel=tolerance, abs=tolerance)
    assert len(result.channels) == expected.shape[-1]


@pytest.mark.parametrize("case", cases(), ids=name)
def test_constant_map(case):
    assert_same(case, tolerance=2e-3 if case.get("film") == "float16" else 1e-4)


def test_channels_are_named_as_in_the_film():
    description = scene("aov", film="rgba")
    loaded = mi.load_dict(description)
    mitsuba_picture(loaded, 0, 1)
    expected = [field.name for field in loaded.sensors()[0].film().bitmap().struct_()]
    assert tracer.render(description, spp=1).channels == expected


def test_each_of_several_sensors():
    description = scene()
    second = scene(sensor="orthographic", film="crop")["sensor"]
    loaded = mi.load_dict(description | {"other": second})
    for k in range(2):
        expected = np.array(mitsuba_picture(loaded, 3, SPP, sensor=k))
        found = tracer.render(loaded, sensor=k, spp=SPP, seed=3, criterion="uniform").image
        assert found == pytest.approx(expected, rel=1e-4, abs=1e-4)


def test_negative_values_survive():
    """A filter with lobes beside a bright edge: below zero in ``mi.render``, and so here."""
    t = mi.ScalarTransform4f()
    lamp = {"type": "rectangle", "to_world": t.translate([1, 0, 0]), "emitter": {"type": "area", "radiance": 9.0}}
    film = {"type": "hdrfilm", "width": 12, "height": 8, "rfilter": {"type": "lanczos"}}
    camera = {"type": "orthographic", "to_world": t.look_at([0, 0, 3], [0, 0, 0], [0, 1, 0]), "film": film}
    description = {"type": "scene", "integrator": {"type": "direct"}, "lamp": lamp, "sensor": camera}
    result = tracer.render(description, spp=64)
    assert result.image.min() < -0.01
    assert result.samples[:, :3].max() <= result.samples.max()


@pytest.mark.slow
@pytest.mark.parametrize("variant", [name for name in mi.variants() if name.startswith("llvm")])
def test_every_llvm_variant(variant):
    folder = Path(__file__).parents[1]
    subprocess.run([sys.executable, "-m", "conformance.variant", variant], check=True, cwd=folder)
