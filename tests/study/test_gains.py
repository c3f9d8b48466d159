"""Gains, their intervals, and what an oracle could gain."""

import numpy as np
import pytest

from tracer.image import objective
from tracer.study import gains, oracle
from tracer.study.gains import error_rate, gain, geometric_mean


def test_a_gain_is_the_ratio_of_means_over_what_it_cost():
    found = gain([1.0, 3.0], [4.0, 12.0], [1.0, 1.0])
    assert found.value == pytest.approx(4)
    assert gain([1.0, 3.0], [4.0, 12.0], [2.0, 8.0]).value == pytest.approx(1)
    assert gain([1.0, 3.0], [4.0, 12.0], [4.0, 4.0], rate=0.5).value == pytest.approx(2)
    assert gain([0.0], [0.0], [1.0]).value == pytest.approx(1)


def test_seeds_are_paired():
    """Methods that share the luck of a seed have a sharp ratio."""
    luck = np.array([1.0, 5.0, 2.0, 9.0, 4.0])
    found = gain(luck, 2 * luck, np.ones(5)).interval
    assert found.mean == pytest.approx(2)
    assert np.isnan(found.low)  # no spread at all: nothing to be said
    shuffled = gain(luck, 2 * luck[::-1], np.ones(5)).interval
    assert shuffled.low < 1.5 < 2.5 < shuffled.high


def test_one_seed_has_no_interval():
    found = gain([1.0], [2.0], [1.0]).interval
    assert (found.mean, np.isnan(found.low), np.isnan(found.high)) == (2.0, True, True)


def coverage(seeds, trials=600):
    """Return the share of intervals over log-normal errors that hold the true ratio."""
    generator = np.random.default_rng(seeds)
    held = 0
    for key in range(trials):
        errors, baseline = np.exp(0.3 * generator.standard_normal((2, seeds)))
        found = gain(errors, 2 * baseline, np.ones(seeds), key=key).interval
        held += found.low <= 2 <= found.high
    return held / trials


@pytest.mark.slow
@pytest.mark.parametrize(("seeds", "least", "most"), [(40, 0.92, 0.98), (5, 0.87, 0.98)])
def test_intervals_hold_what_they_say(seeds, least, most):
    """Of 600 intervals 95 % hold the true ratio, of five seeds nearly so; bounds are three standard errors and more."""
    assert least <= coverage(seeds) <= most


def test_geometric_mean_over_scenes():
    generator = np.random.default_rng(2)
    scenes = [gain(np.ones(5), np.exp(generator.normal(k, 0.2, 5)), np.ones(5), key=k) for k in range(3)]
    found = geometric_mean(scenes)
    assert found.mean == pytest.approx(np.prod([one.value for one in scenes]) ** (1 / 3))
    widths = [np.log(one.interval.high / one.interval.low) for one in scenes]
    assert np.log(found.high / found.low) < np.mean(widths)  # errors of scenes average out


def test_rate_at_which_an_error_falls():
    """Seconds and errors of several seeds at each budget, both with some luck in them."""
    luck = np.exp(0.05 * np.random.default_rng(4).standard_normal((2, 3, 5)))
    seconds = np.array([[1.0], [2.0], [4.0]]) * luck[0]
    assert error_rate(seconds, 3 * np.array([[1.0], [2.0], [4.0]]) ** -1.3 * luck[1]) == pytest.approx(1.3, abs=0.1)
    assert error_rate(seconds[:1], luck[1, :1]) == 1  # one budget says nothing
    assert error_rate(seconds, 0 * seconds) == 1
    assert error_rate(seconds, seconds) == gains.SLOWEST


def test_oracle_is_neymans():
    """Brute force: the best allocation of a budget has n proportional to s sqrt(w)."""
    generator = np.random.default_rng(3)
    variance, mean = generator.random((6, 5, 3)) ** 3, generator.random((6, 5, 3))
    weight = objective.weights("relative", mean @ [0.212671, 0.71516, 0.072169])
    importance = np.sqrt(variance.sum(axis=-1) * weight)
    share = importance / importance.mean()
    uniform = np.sum(weight * variance.sum(axis=-1))
    best = np.sum(weight * variance.sum(axis=-1) / share)
    assert oracle.limit(variance, mean, "relative") == pytest.approx(uniform / best)
    for _ in range(50):
        other = share * np.exp(0.1 * generator.standard_normal(share.shape))
        assert np.sum(weight * variance.sum(axis=-1) / (other / other.mean())) >= best


def test_share_of_the_oracle():
    assert oracle.share(2.0, 4.0) == pytest.approx(0.5)
    assert oracle.share(1.0, 4.0) == 0
    assert oracle.share(2.0, 1.05) is None
    assert oracle.limit(np.zeros((2, 2, 3)), np.ones((2, 2, 3)), "relative") == 1
