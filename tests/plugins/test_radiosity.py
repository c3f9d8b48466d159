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


@pytest.mark.parametrize(
    ("settings", "largest"),
    [
        ({"show": "patches"}, 0.05),
        ({"show": "smooth"}, 0.05),
        ({"show": "gather"}, 0.04),
        ({"guided": False}, 0.04),
        ({"method": "shooting", "rays": 1024, "residual": 1e-4}, 0.04),
    ],
)
def test_looks_as_paths_do(box, expected, settings, largest):
    integrator = mi.load_dict({"type": "radiosity", "size": 0.1, **settings})
    found = mi.render(box, integrator=integrator, spp=128).numpy()
    assert found.mean() == pytest.approx(expected.mean(), rel=0.01)
    assert np.abs(found - expected).mean() / expected.mean() < largest
    assert integrator.solution.residual <= integrator.residual


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


def test_wrong_words():
    with pytest.raises((SettingsError, RuntimeError), match="show, of gather, smooth, patches"):
        mi.load_dict({"type": "radiosity", "show": "nothing"})


def test_round_shapes_and_what_is_not_diffuse():
    """A furnace: in light of 1 from everywhere, what reflects a half looks 1/2 where it is convex, whatever it is."""
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}}
    scene = {
        "type": "scene",
        "sky": {"type": "constant"},
        "ball": {"type": "sphere", "center": [-1.2, 0, 0], "bsdf": {"type": "twosided", "both": grey}},
        "rod": {"type": "cylinder", "p0": [1, 0, -1], "p1": [1, 0, 1], "radius": 0.3, "bsdf": grey},
        "sensor": {
            "type": "perspective",
            "to_world": mi.ScalarTransform4f().look_at([0, 6, 0.5], [0, 0, 0], [0, 0, 1]),
            "film": {"type": "hdrfilm", "width": 64, "height": 48, "rfilter": {"type": "box"}},
        },
    }
    loaded = mi.load_dict(scene)
    path = mi.render(loaded, integrator=mi.load_dict({"type": "path"}), spp=256).numpy()[..., :3]
    for show in ("gather", "smooth", "patches"):
        integrator = mi.load_dict({"type": "radiosity", "size": 0.2, "show": show})
        found = mi.render(loaded, integrator=integrator, spp=64).numpy()[..., :3]
        assert np.abs(found - path).mean() < (0.03 if show == "gather" else 0.01)
        assert found.mean() == pytest.approx(path.mean(), rel=0.005)


def test_smooth_is_smoother_than_patches(box):
    pictures = {}
    for show in ("smooth", "patches"):
        integrator = mi.load_dict({"type": "radiosity", "size": 0.4, "rays": 1024, "show": show})
        pictures[show] = mi.render(box, integrator=integrator, spp=64).numpy()[11:18, 14:36]
    steps = {show: np.abs(np.diff(picture, axis=1)).max() for show, picture in pictures.items()}
    assert steps["smooth"] < 0.5 * steps["patches"]
