"""Chances are in proportion to the root of the second moment, and what is not known is taken from the larger cell."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.guiding.fit import STOCK_SHARE, Tally, chances, light_ratios, slot_moments
from tracer.guiding.slots import plan_slots


def plan_of(*sides):
    low = np.random.default_rng(0).random((len(sides), 3))
    return plan_slots(np.array(sides), low, low)


def test_a_tally_counts():
    cell, slot, square = np.array([0, 0, 1, 1, 1]), np.array([0, 1, 1, 1, 0]), np.array([1.0, 2, 3, 4, 5])
    tally = Tally.of(cell, slot, square, (2, 3))
    assert tally.count.tolist() == [[1, 1, 0], [1, 2, 0]]
    assert tally.squares.tolist() == [[1, 2, 0], [5, 7, 0]]


def test_many_trials_give_neymans_rule():
    """Four lights that give 0, 1, 2 and 4 units half of the time: their chances are as 0 to 1 to 2 to 4."""
    random, count = np.random.default_rng(0), 400_000
    slot = random.integers(0, 4, count)
    given_ = np.array([0.0, 1, 2, 4])[slot] * (random.random(count) < 0.5)
    tally = Tally.of(np.zeros(count, int), slot, given_**2, (1, 4))
    found = chances(slot_moments(tally, even(tally), [np.zeros(1, int)], plan_of(1, 1, 1, 1))[-1], plan_of(1, 1, 1, 1))[
        0
    ]
    expected = (1 - STOCK_SHARE) * np.array([0, 1, 2, 4]) / 7 + STOCK_SHARE / 4
    assert np.allclose(found, expected, atol=0.01)


def test_these_chances_are_the_best():
    """No other chances have a smaller second moment, sum of M_k / p_k (brute force over random ones)."""
    moments = np.array([[0.2, 3.0, 0.5, 9.0]])
    best = np.sqrt(moments) / np.sqrt(moments).sum()
    others = np.random.default_rng(0).dirichlet(np.ones(4), 10_000)
    assert (moments / best).sum() <= (moments / others).sum(axis=1).min()


def test_a_cell_without_trials_has_the_chances_of_the_larger_one():
    plan = plan_of(1, 1, 1)
    count = np.array([[50.0, 50, 50], [0, 0, 0], [10, 10, 10]])
    squares = np.array([[50.0, 200, 0], [0, 0, 0], [0, 0, 1000]])
    _, around, here = slot_moments(Tally(count, squares), np.ones(count.shape), [np.array([0, 0, 1])], plan)
    assert np.allclose(chances(here, plan)[1], chances(around, plan)[0])
    assert chances(here, plan)[2, 2] > 0.6


def test_a_dark_cell_follows_the_larger_one_in_proportion():
    """The larger cell is a thousand times as bright: what it says of ratios counts, not what it says of the level."""
    plan = plan_of(1, 1)
    count, squares = np.array([[100.0, 100], [4, 0]]), np.array([[1e3, 4e3], [1e-3, 0]])
    *_, here = slot_moments(Tally(count, squares), np.ones(count.shape), [np.array([0, 0])], plan)
    assert here[1, 1] / here[1, 0] == pytest.approx(4, rel=0.2)


def test_parts_are_expected_to_be_as_their_light():
    plan = plan_of(4, 1)
    count, squares = np.full(17, 10.0), np.r_[20.0, np.full(15, 18.0), 0.0]
    ratios = light_ratios(squares, count, np.ones(17), plan)[0]
    assert np.allclose(ratios[:16], ratios[0])
    assert ratios[16] < 0.3 * ratios[0]


def test_a_light_that_was_seen_from_afar_is_expected_near_by():
    """Two cells: in one a light was tried and gave 1; in the other, where it must give 16, nothing was tried."""
    plan, geometry = plan_of(1, 1), np.array([[1.0, 1.0], [16.0, 1.0]])
    tally = Tally(np.array([[100.0, 100], [0, 0]]), np.array([[100.0, 100], [0, 0]]))
    *_, here = slot_moments(tally, geometry, [np.zeros(2, int)], plan)
    assert here[1, 0] / here[1, 1] == pytest.approx(16, rel=0.1)
    assert chances(here, plan)[1, 0] == pytest.approx((1 - STOCK_SHARE) * 0.8 + STOCK_SHARE / 2, rel=0.02)


def even(tally):
    return np.ones(tally.count.shape)


@given(st.integers(0, 2**32 - 1), st.lists(st.sampled_from([1, 2, 4]), min_size=1, max_size=8))
def test_chances_are_chances(seed, sides):
    random, plan = np.random.default_rng(seed), plan_of(*sides)
    count = random.poisson(1.0, (5, len(plan.stock))).astype(float)
    squares = count * random.exponential(1.0, count.shape) * 10.0 ** random.uniform(-30, 30)
    for moments in slot_moments(Tally(count, squares), np.ones(count.shape), [np.array([0, 0, 1, 1, 1])], plan):
        found = chances(moments, plan)
        assert np.allclose(found.sum(axis=1), 1)
        assert np.all(found >= STOCK_SHARE * plan.stock * (1 - 1e-9))
