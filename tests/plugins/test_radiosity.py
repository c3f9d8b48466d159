"""The integrator ``radiosity`` under ``mi.render`` and under our loop, against the path tracer."""

import mitsuba as mi
import numpy as np
import pytest

import tracer
from tracer.errors import SettingsError


@pytest.fixture(scope="module")
def box():
    scene = mi.cornell_box()
    scene["sensor"]["film"] |= {"width": 48, "height": 48}
    return mi.load_dict(scene)


@pytest.fixture(scope="module")
def expected(box):
    path = mi.load_dict({"type": "path", "max_depth": 64, "rr_depth": 64})
    return mi.render(box, integrator=path, spp=1024).numpy()


@pytest.mark.parametrize(("final_gather", "largest"), [(False, 0.05), (True, 0.04)])
def test_looks_as_paths_do(box, expected, final_gather, largest):
    integrator = mi.load_dict({"type": "radiosity", "size": 0.1, "final_gather": final_gather})
    found = mi.render(box, integrator=integrator, spp=128).numpy()
    assert found.mean() == pytest.approx(expected.mean(), rel=0.01)
    assert np.abs(found - expected).mean() / expected.mean() < largest
    assert integrator.solution.residual < 1e-5


def test_under_our_loop(box, expected):
    integrator = {"type": "radiosity", "size": 0.2, "rays": 64}
    found = tracer.render(box, integrator=integrator, spp=64, criterion="uniform").image
    assert found.mean() == pytest.approx(expected.mean(), rel=0.02)


def test_solved_once(box):
    integrator = mi.load_dict({"type": "radiosity", "size": 0.5, "rays": 16})
    mi.render(box, integrator=integrator, spp=1)
    before = integrator.solution
    mi.render(box, integrator=integrator, spp=1)
    assert integrator.solution is before


@pytest.mark.parametrize("wrong", [{"size": -1.0}, {"rays": 0}, {"residual": 2.0}])
def test_wrong_parameters(wrong):
    with pytest.raises((SettingsError, RuntimeError), match="radiosity: size must be positive"):
        mi.load_dict({"type": "radiosity", **wrong})
