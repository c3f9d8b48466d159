"""Predicted gains, fallback to uniform, and what each kind of criterion does with its importance."""

from types import SimpleNamespace

import numpy as np
import pytest

from tracer.adaptive.allocation import decide
from tracer.adaptive.decision import Situation
from tracer.criteria import Criterion, Evidence
from tracer.settings import make_settings

GRID = (8, 8)


def situation(drawn, goal, total=None, may_settle=True):
    return Situation(drawn.astype(np.uint32), goal, goal if total is None else total, may_settle)


def evidence(wanted=None, work=4.0, count=4):
    statistics = SimpleNamespace(work=np.broadcast_to(np.float32(work), GRID), count=np.full(GRID, count))
    ones = np.ones(GRID)
    return Evidence(
        look=lambda: pytest.fail("nobody asked for pilot rays"),
        statistics=statistics,
        before=None,
        weight=ones,
        weight_before=None,
        colour_channels=3,
        wanted=ones if wanted is None else wanted,
    )


def run(spends, importance, now, settings=None, **known):
    criterion = Criterion("made up", lambda _: importance, True, spends)
    return decide(criterion, evidence(**known), settings or make_settings(spp=16), now, np.random.default_rng(0))


def test_where_the_pixels_to_spare_cost_nothing_there_is_nothing_to_gain():
    half = np.repeat([[0.0], [1.0]], 4, axis=0) * np.ones((1, 8))
    now = situation(np.full(GRID, 4), 8 * 64, 16 * 64)
    assert not run("deviation", 0.3 + half, now, work=5.0).settled
    assert run("deviation", 0.3 + half, now, make_settings(spp=16, cost="none"), work=1.0 + 99 * half).settled


def test_a_deviation_is_followed_where_it_pays_and_not_where_it_does_not():
    drawn, half = np.full(GRID, 4), np.repeat([[1.0], [9.0]], 4, axis=0) * np.ones((1, 8))
    decision = run("deviation", half, situation(drawn, 8 * 64, 16 * 64))
    assert not decision.settled
    assert decision.allocation.sum() == 8 * 64
    assert decision.allocation[4:].mean() > 2 * decision.allocation[:4].mean()
    even = run("deviation", 1 + 0.01 * half, situation(drawn, 8 * 64, 16 * 64))
    assert even.settled
    assert np.all(even.allocation == 16)
    assert "would gain a factor of 1.00" in even.note
    held = run("deviation", 1 + 0.01 * half, situation(drawn, 8 * 64, 16 * 64, may_settle=False))
    assert not held.settled
    assert np.all(held.allocation == 8)


def test_further_samples_are_shared_whatever_was_drawn():
    drawn = np.arange(64).reshape(GRID)
    decision = run("more", np.ones(GRID), situation(drawn, drawn.sum() + 640))
    assert np.all(decision.allocation == drawn + 10)


def test_priority_serves_the_first_with_as_many_as_they_have():
    drawn = np.full(GRID, 4)
    decision = run("priority", np.arange(64.0).reshape(GRID), situation(drawn, 4 * 64 + 40))
    assert np.array_equal(np.flatnonzero(decision.allocation.ravel() > 4), np.arange(54, 64))
    assert decision.allocation.max() == 8


@pytest.mark.parametrize("spends", ["share", "deviation", "more", "priority"])
def test_nobody_gets_more_than_the_least_where_nothing_is_wanted(spends):
    wanted = np.ones(GRID)
    wanted[:, :4] = 0
    drawn = np.full(GRID, 2)
    importance = np.random.default_rng(1).uniform(1, 2, GRID)
    allocation = run(spends, importance, situation(drawn, 6 * 64), wanted=wanted).allocation
    assert allocation.sum() == 6 * 64
    assert np.all(allocation[:, :4] == 2)
    assert np.all(allocation[:, 4:] > 2)


def test_where_a_mask_is_all_there_is_to_follow_no_more_is_decided():
    wanted = np.ones(GRID)
    wanted[:, :4] = 0
    decision = run("deviation", np.full(GRID, 0.3), situation(np.full(GRID, 4), 8 * 64, 16 * 64), wanted=wanted)
    assert decision.settled
    assert np.all(decision.allocation[:, :4] == 4)
    assert np.all(decision.allocation[:, 4:] == 28)


def test_after_one_sample_it_is_too_early_to_settle():
    now = situation(np.full(GRID, 1), 2 * 64, 16 * 64)
    assert run("deviation", np.zeros(GRID), now, count=4).settled
    assert run("deviation", np.zeros(GRID), now, count=2).settled
    decision = run("deviation", np.zeros(GRID), now, count=1)
    assert not decision.settled
    assert np.all(decision.allocation == 2)


@pytest.mark.parametrize("spends", ["share", "deviation", "more", "priority"])
def test_the_least_is_kept_by_every_kind(spends):
    importance = np.zeros(GRID)
    importance[0, 0] = 1
    now = situation(np.zeros(GRID), 16 * 64)
    assert run(spends, importance, now).allocation.min() >= 1
    asked = make_settings(spp=16, min_spp=8)
    allocation = run(spends, importance, now, settings=asked).allocation
    assert allocation.min() == 8
    assert allocation.sum() == 16 * 64
    halfway = run(spends, importance, situation(np.full(GRID, 2), 8 * 64, 16 * 64), settings=asked).allocation
    assert halfway.min() == 4


def test_who_is_served_by_priority_begins_with_one_sample():
    """One each, then one more each, then two more for those that come first: 64 + 64 + 64."""
    decision = run("priority", np.arange(1.0, 65.0).reshape(GRID), situation(np.zeros(GRID), 3 * 64))
    assert np.array_equal(decision.allocation.ravel(), np.repeat([2, 4], 32))


def test_nobody_gets_further_samples_beyond_the_most():
    importance = np.full(GRID, 1e-3)
    importance[0, 0] = 1
    settings = make_settings(spp=16, max_spp=20)
    decision = run("more", importance, situation(np.full(GRID, 12), 16 * 64), settings=settings)
    assert decision.allocation[0, 0] == decision.allocation.max() == 20


def two_costs():
    """Return the work of a sample in two halves, 1 and 9, and what a pixel costs: the mean over 3 x 3 neighbours."""
    work = np.repeat([[1.0], [9.0]], 4, axis=0) * np.ones((1, 8))
    rows = [1, 1, 1, 11 / 3, 19 / 3, 9, 9, 9]
    return work, np.array(rows)[:, None] * np.ones((1, 8))


@pytest.mark.parametrize("cost", ["none", "root", "work"])
def test_of_two_pixels_of_one_deviation_the_dearer_gets_fewer_samples(cost):
    """With deviations s and costs c the error sum s^2 / n is least, at equal cost, for n ~ s / sqrt(c): work."""
    work, costs = two_costs()
    deviation = np.random.default_rng(3).uniform(1, 4, GRID)
    now = situation(np.full(GRID, 4), 8 * 64, 64 * 64)
    decision = run("deviation", deviation, now, settings=make_settings(spp=64, cost=cost), work=work)
    expected = deviation / costs ** {"none": 0, "root": 0.25, "work": 0.5}[cost]
    assert decision.importance == pytest.approx(expected)


def test_importance_that_is_no_number_is_none_at_all():
    importance = np.ones(GRID)
    importance[2, 3] = np.inf
    assert np.all(run("share", importance, situation(np.zeros(GRID), 16 * 64)).allocation == 16)


def test_shares_are_those_of_the_criterion_and_not_rounded_to_powers_of_two():
    importance = np.random.default_rng(2).uniform(1, 3, GRID)
    allocation = run("share", importance, situation(np.zeros(GRID), 16 * 64)).allocation
    assert np.all(np.abs(allocation - 16 * importance / importance.mean()) < 1)
