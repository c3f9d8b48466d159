"""What is opened: integrators that cannot be sampled are refused before they end the process."""

import mitsuba as mi
import pytest

import tracer
from tracer.errors import SceneError, SettingsError

STOKES = {"type": "stokes", "inner": {"type": "path"}}
WITHIN = [
    STOKES,
    {"type": "stokes", "inner": {"type": "volpath"}},
    {"type": "aov", "aovs": "depth:depth", "inner": STOKES},
    {"type": "moment", "inner": STOKES},
    {"type": "adaptive", "inner": STOKES},
    {"type": "moment", "first": {"type": "path"}, "second": {"type": "aov", "aovs": "depth:depth", "inner": STOKES}},
]


@pytest.fixture
def polarized():
    tracer.activate("llvm_ad_mono_polarized")
    yield
    tracer.activate("llvm_ad_rgb")


@pytest.mark.parametrize("integrator", WITHIN)
def test_what_would_end_the_process_is_refused_by_name(cornell, polarized, integrator):
    with pytest.raises((SettingsError, SceneError), match="'stokes' cannot be rendered adaptively") as raised:
        tracer.render(cornell(), integrator=integrator, spp=1)
    assert "\n" not in str(raised.value)


def test_a_scenes_own_integrator_is_refused_too(cornell, polarized):
    scene = mi.load_dict(cornell() | {"integrator": STOKES})
    with pytest.raises(SettingsError, match="'stokes' cannot be rendered adaptively"):
        tracer.render(scene, spp=1)


@pytest.mark.parametrize("name", ["prbvolpath", "volprim_rf_basic"])
def test_what_mitsubas_python_cannot_do_under_a_variant_is_one_sentence(cornell, polarized, name):
    with pytest.raises(SceneError, match="its integrator fails under the active variant with TypeError: ") as raised:
        tracer.render(cornell(), integrator=name, spp=1)
    assert "\n" not in str(raised.value)
