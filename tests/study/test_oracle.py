"""Allocations of an oracle: against a general optimiser, for both budgets, and rendered."""

import mitsuba as mi
import numpy as np
import pytest
from scipy.optimize import minimize

from tracer.image import objective
from tracer.scene.view import open_scene
from tracer.study import oracle
from tracer.study.methods import Setting
from tracer.study.oracle_measurements import SEEDS_OF, Truth, measure_truth

COUNTS = np.array(list(SEEDS_OF))


def made_up(scale, rate, cost):
    """Return a truth whose errors are scale * n^-rate (H, W)."""
    error = np.stack([scale * n**-rate for n in COUNTS.astype(float)])
    return Truth(COUNTS, np.array(list(SEEDS_OF.values())), error, np.ones(scale.shape), cost / cost.mean())


@pytest.fixture
def known(monkeypatch):
    monkeypatch.setattr(oracle, "FINE", 1e-3)  # six pixels: nothing to smooth
    monkeypatch.setattr(oracle, "WIDE", 1e-3)
    monkeypatch.setattr(oracle, "LEAST", 1e-9)
    scale = np.array([[1.0, 4.0, 0.3], [9.0, 2.0, 0.05]])
    rate = np.array([[1.0, 1.5, 1.2], [1.0, 1.8, 0.9]])
    cost = np.array([[1.0, 3.0, 0.2], [2.0, 5.0, 0.1]])
    return scale, rate, cost


def test_the_fit_finds_what_errors_were_made_of(known):
    scale, rate, cost = known
    found = oracle.fit(made_up(scale, rate, cost))
    assert found[0] == pytest.approx(scale, rel=1e-5)
    assert found[1] == pytest.approx(rate, rel=1e-5)


@pytest.mark.parametrize("by", ["samples", "time"])
def test_no_other_allocation_of_the_budget_errs_less(known, by):
    scale, rate, cost = known
    truth = made_up(scale, rate, cost)
    price = truth.cost.ravel() if by == "time" else np.ones(6)
    counts = oracle.allocation(truth, "absolute", 32, by)
    assert np.sum(counts.ravel() * price) == pytest.approx(32 * price.sum(), rel=1e-6)

    def error(logarithms):
        return np.sum(scale.ravel() * np.exp(-rate.ravel() * logarithms))

    budget = {"type": "eq", "fun": lambda x: np.sum(np.exp(x) * price) / (32 * price.sum()) - 1}
    best = minimize(error, np.full(6, np.log(32.0)), constraints=[budget], bounds=[(0, 8)] * 6)
    assert best.success
    assert error(np.log(counts.ravel())) == pytest.approx(best.fun, rel=1e-4)
    assert error(np.full(6, np.log(32.0))) > 1.05 * best.fun


def test_a_scene_without_noise_is_uniform():
    nothing = np.zeros((4, 5))
    truth = Truth(COUNTS, np.array(list(SEEDS_OF.values())), np.zeros((3, 4, 5)), nothing, nothing + 1)
    assert oracle.allocation(truth, "relative", 16, "samples") == pytest.approx(np.full((4, 5), 16))


def test_what_is_measured_of_a_scene(tmp_path, monkeypatch):
    monkeypatch.setenv("TRACER_CACHE", str(tmp_path))
    monkeypatch.setattr("tracer.study.oracle_measurements.SQUARE", 8)
    T = mi.ScalarTransform4f
    rod = {"type": "cylinder", "p0": [0, -2, 0], "p1": [0, 2, 0], "radius": 0.05}
    film = {"type": "hdrfilm", "width": 24, "height": 16}
    camera = {"type": "perspective", "to_world": T().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]), "film": film}
    scene = {"type": "scene", "i": {"type": "path"}, "rod": rod, "sky": {"type": "constant"}, "sensor": camera}
    scene["rod"] |= {"bsdf": {"type": "diffuse", "reflectance": 0.1}}
    setting, told = Setting(scene), []
    with open_scene(scene) as view:
        truth = measure_truth(setting, view, told.append)
        assert told
        told.clear()
        again = measure_truth(setting, view, told.append)
    assert not told  # it was kept
    assert np.array_equal(truth.squared_error, again.squared_error)
    assert truth.squared_error.shape == (3, 16, 24)
    assert truth.cost.mean() == pytest.approx(1)
    middle, sky = truth.squared_error[:, :, 11:13].mean(axis=(1, 2)), truth.squared_error[:, :, :8].mean(axis=(1, 2))
    assert np.all(middle > 100 * sky)
    assert np.all(np.diff(middle) < 0)
    assert middle[0] > 4.5 * middle[1]  # of independent samples 4 times as many err 4 times less
    counts = oracle.allocation(truth, "relative", 16, "samples")
    assert counts[:, 11:13].mean() > 5 * counts[:, :8].mean()
    for by in ("samples", "time"):
        drawn = oracle.rendered_allocation(truth, "relative", 16, by)
        assert drawn.mean() == pytest.approx(round(drawn.mean()))
        assert drawn.min() >= 1


def test_pixels_that_clip_are_not_starved_of_what_keeps_them_clipped(known):
    scale, rate, cost = known
    kept = made_up(scale * 100, rate, cost)
    truth = Truth(kept.counts, kept.seeds, kept.squared_error, np.full(scale.shape, 1.5), kept.cost)
    counts = oracle.allocation(truth, "display", 64, "samples")
    assert counts.min() >= 8
    assert counts.mean() == pytest.approx(64)
    assert counts[1, 0] > 4 * counts[1, 2]  # noise that reaches below white still counts


def test_a_secant_over_little_noise_is_the_slope():
    luminance = np.array([0.001, 0.2, 0.7])
    slope = objective.weights("display", luminance)
    assert oracle.secant(luminance, np.full(3, 1e-5)) == pytest.approx(slope, rel=1e-3)
    assert oracle.secant(np.array([2.0]), np.array([0.5])) == 0
    assert oracle.secant(np.array([0.5]), np.zeros(1)) == 0
