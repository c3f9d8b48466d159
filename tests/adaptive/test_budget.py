"""Allocations: optimal within their bounds, exact in total, unbiased in rounding."""

import mitsuba as mi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.optimize import minimize

from tracer.adaptive import budget
from tracer.core.device import to_host, upload
from tracer.errors import BudgetError


def bound(value):
    return float(value) if np.ndim(value) == 0 else upload(mi.Float64, value)


def fill(importance, total, lower, upper):
    """Return the counts as NumPy."""
    shape = np.shape(importance)
    return to_host(budget.fill(upload(mi.Float64, importance), total, bound(lower), bound(upper)), shape)


def suit_sequence(target, total, lower, upper):
    """Return the counts as NumPy."""
    shape = np.shape(target)
    return to_host(budget.suit_sequence(upload(mi.Float64, target), total, bound(lower), bound(upper)), shape)


def round_to_total(counts, total, generator):
    """Return the counts as NumPy."""
    return to_host(budget.round_to_total(upload(mi.Float64, counts), total, generator), np.shape(counts))


importance = hnp.arrays(np.float64, st.integers(1, 60), elements=st.floats(0, 1e6, allow_subnormal=False))


@given(importance, st.floats(1, 50), st.floats(0, 1), st.floats(1, 20))
def test_fill_meets_total_and_bounds(weights, mean, low, high):
    total = mean * len(weights)
    filled = fill(weights, total, low * mean, high * mean)
    assert filled.sum() == pytest.approx(total, rel=1e-9)
    assert np.all(filled >= low * mean * (1 - 1e-12))
    assert np.all(filled <= high * mean * (1 + 1e-12))


@given(importance, st.floats(1, 50))
def test_fill_keeps_the_order_of_importance(weights, mean):
    filled = fill(weights, mean * len(weights), 0.3 * mean, 4 * mean)
    order = np.argsort(weights, kind="stable")
    assert np.all(np.diff(filled[order]) >= -1e-9 * mean)


def test_fill_minimises_the_error_as_a_general_solver_does():
    rng = np.random.default_rng(4)
    deviation = rng.lognormal(0, 1, 8)
    found = fill(deviation, 80, 4, 25)
    brute = minimize(
        lambda n: np.sum(deviation**2 / n),
        np.full(8, 10.0),
        bounds=[(4, 25)] * 8,
        constraints={"type": "eq", "fun": lambda n: n.sum() - 80},
        options={"maxiter": 1000, "ftol": 1e-14},
    )
    assert np.sum(deviation**2 / found) <= brute.fun * (1 + 1e-6)
    assert found == pytest.approx(brute.x, rel=1e-2)


def test_fill_keeps_what_is_drawn_already():
    drawn = np.array([4.0, 20.0, 4.0])
    filled = fill([1, 1, 2], 40, drawn, 100)
    assert filled == pytest.approx([20 / 3, 20, 40 / 3])


def test_no_importance_at_all_is_uniform():
    assert fill(np.zeros(4), 40, 1, 100) == pytest.approx([10] * 4)


@pytest.mark.parametrize(("low", "high"), [(11, 20), (1, 9)])
def test_impossible_bounds_are_one_sentence(low, high):
    with pytest.raises(BudgetError, match="No allocation of 40 samples fits"):
        fill(np.ones(4), 40, low, high)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -1.0])
def test_importance_must_be_a_number(bad):
    with pytest.raises(ValueError, match="finite and not negative"):
        fill([1, bad], 10, 1, 9)


@settings(max_examples=200)
@given(importance, st.integers(1, 50), st.integers(0, 2**32 - 1))
def test_rounding_is_exact_in_total_and_within_one(weights, mean, seed):
    total = mean * len(weights)
    filled = fill(weights, total, 0.25 * mean, 8 * mean)
    rounded = round_to_total(filled, total, np.random.default_rng(seed))
    assert rounded.sum() == total
    assert np.all(np.abs(rounded - filled) < 1 + 1e-6)


def test_rounding_is_unbiased():
    counts = fill(np.linspace(1, 3, 30), 200, 1, 100)
    rng = np.random.default_rng(1)
    repeats = 4000
    mean = np.mean([round_to_total(counts, 200, rng) for _ in range(repeats)], axis=0)
    # 30 pixels, standard error at most 0.5 / sqrt(repeats): 4.5 of these is a false alarm in 5000 runs
    assert np.max(np.abs(mean - counts)) < 4.5 * 0.5 / np.sqrt(repeats)


def test_rounding_is_seeded():
    counts = np.full(100, 2.5)
    first, second = (round_to_total(counts, 250, np.random.default_rng(7)) for _ in range(2))
    assert np.array_equal(first, second)
    assert not np.array_equal(first, round_to_total(counts, 250, np.random.default_rng(8)))


@given(
    drawn=hnp.arrays(np.uint32, (20,), elements=st.integers(0, 9)),
    priority=hnp.arrays(np.float64, (20,), elements=st.floats(0, 9)),
    more=st.integers(0, 2000),
)
def test_serving_adds_up_and_takes_nothing_away(drawn, priority, more):
    total = int(drawn.sum()) + more
    if total > 20 * 64:
        with pytest.raises(BudgetError):
            budget.serve(priority, total, drawn, 64, np.random.default_rng(0))
        return
    counts = budget.serve(priority, total, drawn, 64, np.random.default_rng(0))
    assert counts.sum() == total
    assert np.all(counts >= drawn)
    assert counts.max() <= 64


@given(importance, st.floats(1, 50), st.floats(0, 1), st.floats(1, 20))
def test_suited_counts_meet_total_and_bounds_and_stay_near(weights, mean, low, high):
    total = mean * len(weights)
    target = fill(weights, total, low * mean, high * mean)
    suited = suit_sequence(target, total, low * mean, high * mean)
    assert suited.sum() == pytest.approx(total, rel=1e-9)
    assert np.all(suited >= low * mean * (1 - 1e-12))
    assert np.all(suited <= high * mean * (1 + 1e-12) + low * mean)


def test_most_suited_counts_are_powers_of_two_and_cost_little():
    rng = np.random.default_rng(5)
    importance = np.exp(rng.normal(0, 1, 20_000))
    target = fill(importance, 64 * 20_000, 1, 1e6)
    suited = suit_sequence(target, 64 * 20_000, 1, 1e6)
    powers = np.isclose(np.log2(suited), np.rint(np.log2(suited)), atol=1e-9)
    assert powers.mean() > 0.75
    assert np.sum(importance**2 / suited) < 1.04 * np.sum(importance**2 / target)


@pytest.mark.parametrize("spp", [24, 64])
def test_suited_counts_of_equal_targets_are_equal(spp):
    assert suit_sequence(np.full(100, float(spp)), spp * 100, 4, 1e4) == pytest.approx(np.full(100, spp))


def test_a_pixel_of_no_importance_takes_samples_only_when_all_others_are_full():
    assert fill([0, 1, 3], 30, 0, 25) == pytest.approx([0, 7.5, 22.5], abs=1e-3)
    assert fill([0, 1, 3], 40, 0, 19) == pytest.approx([2, 19, 19], abs=1e-3)


def test_who_of_equals_is_served_is_left_to_chance():
    drawn = np.ones(100, np.uint32)
    served = [budget.serve(np.ones(100), 150, drawn, 9, np.random.default_rng(seed)) == 2 for seed in range(2)]
    assert [each.sum() for each in served] == [50, 50]
    # 50 of 100 twice: 25 in common are expected, and 25 +- 14 is left in fewer than one of 10^7 cases
    assert abs((served[0] & served[1]).sum() - 25) < 14
    assert all(abs(each[:50].sum() - 25) < 14 for each in served)


def test_what_is_served_again_begins_from_the_top():
    """One more each for all, then two more each for the first."""
    counts = budget.serve([3, 1, 2, 0], 9, np.ones(4, np.uint32), 64, np.random.default_rng(0))
    assert counts.tolist() == [4, 2, 2, 1]


def test_suited_counts_of_pictures_whose_columns_differ():
    """65 536 pixels are 16 times as many as are looked at: every 16th would be those of the same columns."""
    importance = np.exp(np.random.default_rng(6).normal(0, 1, (256, 256)))
    importance[:, ::16] = 30
    total = 64 * importance.size
    target = fill(importance, total, 1, 1e6)
    suited = suit_sequence(target, total, 1, 1e6)
    powers = np.isclose(np.log2(suited), np.rint(np.log2(suited)), atol=1e-9)
    assert powers.mean() > 0.75


def test_targets_that_are_all_rounded_down_leave_no_samples_over():
    """Of 2^4.1 to 2^4.4 all would be 16: a part of them, that with the most, is 32."""
    target = 2.0 ** np.random.default_rng(7).uniform(4.1, 4.4, 5000)
    suited = suit_sequence(target, target.sum(), 1, 1e6)
    assert (np.isclose(suited, 16) | np.isclose(suited, 32)).mean() > 0.9
    assert suited[target > 2**4.37].mean() > 31
