"""``guided`` is ``path`` until it is given a table, and has the same mean with any table."""

import subprocess
import sys
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

import tracer
from guiding.lights import scene_with_lights
from tracer.guiding.cells import Grid
from tracer.guiding.learn import Lesson
from tracer.guiding.slots import slots_of
from tracer.guiding.table import LightChances

FALSE_ALARM = 0.001
SEEDS = 24


def render(scene, integrator, seed=0, spp=64):
    return tracer.render(scene, integrator=integrator, spp=spp, seed=seed, criterion="uniform").image


@pytest.mark.parametrize(
    "parameters",
    [{}, {"max_depth": 2}, {"max_depth": 0}, {"max_depth": 1}, {"rr_depth": 1}, {"hide_emitters": True}],
    ids=str,
)
@pytest.mark.parametrize("kinds", [("area", "point"), ("sky picture", "sphere"), ("sky",), ()], ids=str)
def test_unguided_it_is_path(kinds, parameters):
    scene = scene_with_lights(*kinds)
    mine, theirs = (render(scene, {"type": name, **parameters}, spp=16) for name in ("guided", "path"))
    assert np.allclose(mine, theirs, rtol=1e-4, atol=1e-5)


def random_chances(scene, seed=0):
    """Return chances at random, different ones in every cell."""
    plan, grid = slots_of(scene), Grid(np.array([-2.0, -2, 0]), 0.5, (8, 8, 4))
    chances = np.random.default_rng(seed).dirichlet(np.ones(len(plan.stock)), 64) + 0.2 * plan.stock
    row = np.random.default_rng(seed).integers(0, 64, grid.cell_count).astype(np.uint32)
    return LightChances(grid, row, chances / chances.sum(axis=1, keepdims=True))


@pytest.mark.parametrize(
    "kinds",
    [("area", "sphere", "point"), ("sky", "sphere"), ("sky picture", "sun"), ("spot",) * 300, ("sky",)],
    ids=str,
)
def test_any_table_has_the_same_mean(kinds, monkeypatch):
    scene = scene_with_lights(*kinds)
    guided = mi.load_dict({"type": "guided", "max_depth": 4})
    theirs = np.stack([render(scene, {"type": "path", "max_depth": 4}, 10**6 + seed, 256) for seed in range(8)])
    teach(monkeypatch, guided, random_chances(scene))
    mine = np.stack([drawn_with(guided, scene, seed) for seed in range(SEEDS)])
    error = np.sqrt(mine.var(axis=0, ddof=1) / SEEDS + theirs.var(axis=0, ddof=1) / 8) + 1e-5
    scores = (mine.mean(axis=0, dtype=float) - theirs.mean(axis=0, dtype=float)) / error
    per_value = 1 - (1 - FALSE_ALARM) ** (1 / scores.size)
    assert abs(scores).max() < stats.t.ppf(1 - per_value / 2, 12)


def teach(monkeypatch, guided, learned):
    """Let an integrator have learned these chances, whatever the scene."""

    def lesson(view, *_, **__):
        return Lesson(learned, 2.0, 1, slots_of(view.scene))

    monkeypatch.setattr(sys.modules[type(guided).__module__], "learn_lights", lesson)


def drawn_with(guided, scene, seed):
    """Return a picture by plain Mitsuba."""
    return np.array(guided.render(scene, seed=seed + 1, spp=64))


def test_a_table_that_never_chooses_a_light_loses_it(monkeypatch):
    """The test above can fail: without the light's chance the picture is darker."""
    scene = scene_with_lights("point", "point")
    guided = mi.load_dict({"type": "guided", "max_depth": 2})
    grid = Grid(np.zeros(3), 1.0, (1, 1, 1))
    teach(monkeypatch, guided, LightChances(grid, np.zeros(6, np.uint32), np.array([[1.0, 0.0]])))
    assert drawn_with(guided, scene, 0).mean() < 0.9 * render(scene, {"type": "path", "max_depth": 2}).mean()


@pytest.mark.parametrize("wrong", [{"max_depth": -2}, {"rr_depth": 0}])
def test_what_cannot_be_is_a_sentence(wrong):
    with pytest.raises(RuntimeError, match=r"guided: (max|rr)_depth must be"):
        mi.load_dict({"type": "guided", **wrong})


def test_no_kernel_is_compiled_for_another_table(monkeypatch):
    scene = scene_with_lights("area", "point", "sky")
    guided = mi.load_dict({"type": "guided", "max_depth": 3})
    pictures = []
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for seed in range(3):
            teach(monkeypatch, guided, random_chances(scene, seed))
            pictures.append(drawn_with(guided, scene, 0))
            compiled = [kernel for kernel in dr.kernel_history() if not kernel.get("cache_hit", 1)]
            assert seed == 0 or not compiled
    assert not np.array_equal(pictures[0], pictures[1])


def test_under_mitsuba_alone_it_learns():
    """Of nine lamps eight are behind a wall far away: the picture has less noise than that of ``path``."""
    scene = scene_with_lights("sphere", *["far lamp"] * 8, size=(64, 48))
    more = {"max_depth": 2, "hide_emitters": True}
    truth = np.array(mi.load_dict({"type": "path", **more}).render(scene, seed=99, spp=4096))
    errors = []
    for name in ("path", "guided"):
        pictures = [mi.load_dict({"type": name, **more}).render(scene, seed=seed, spp=256) for seed in (1, 2)]
        errors.append(np.mean([(np.array(picture) - truth) ** 2 for picture in pictures]))
    assert errors[1] < 0.5 * errors[0]


def test_it_says_what_it_is():
    assert "max_depth = -1" in str(mi.load_dict({"type": "guided"}))


IN_A_VARIANT = """
import subprocess
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
import tracer
tracer.activate({variant!r})
import numpy as np
from guiding.lights import scene_with_lights

glass = {{"type": "sphere", "center": [0.9, -0.5, 0.3], "radius": 0.3, "bsdf": {{"type": "dielectric"}}}}
scene = scene_with_lights("area", "sphere", "sky", glass=glass)
settings = {{"size": 16, "spp": 64, "criterion": "uniform"}}
path, guided = (
    tracer.render(scene, integrator={{"type": name, "max_depth": 5}}, **settings).image for name in ("path", "guided")
)
assert np.allclose(path, guided, rtol=1e-4, atol=1e-5), abs(path - guided).max()
"""


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["llvm_ad_spectral", "llvm_ad_spectral_polarized", "llvm_ad_mono"])
def test_in_every_variant_it_is_path_unguided(variant):
    program = IN_A_VARIANT.format(tests=str(Path(__file__).parents[1]), variant=variant)
    subprocess.run([sys.executable, "-c", program], check=True, timeout=300)
