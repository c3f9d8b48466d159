"""The best choices against values from analysis."""

import numpy as np
import pytest

from benchmarks.guiding.limits import of_whole_lights, roulette_limit, whole
from tracer.guiding.slots import plan_slots
from tracer.guiding.training import Trials


def test_a_part_that_gives_nothing_is_not_worth_its_vertices():
    first = np.random.default_rng(1).exponential(size=4000)
    steps = np.stack([first, 0 * first])
    found = roulette_limit(steps, np.ones(4000), np.array([1.0, 3.0]))
    assert found == pytest.approx(1 / (1 / 4 + 0.01 * 3 / 4), rel=0.01)  # all but one in a hundred paths end


def test_two_parts_agree_with_the_analytic_optimum():
    """For independent parts of mean 0, M = (1, s) and costs (1, c), the best chance of the second is sqrt(s / c)."""
    random = np.random.default_rng(2)
    size, cost = 0.09, 4.0
    steps = np.stack([random.normal(size=400000), np.sqrt(size) * random.normal(size=400000)])
    found = roulette_limit(steps, np.ones(400000), np.array([1.0, cost]))
    best = (1 + np.sqrt(size * cost)) ** 2
    assert found == pytest.approx((1 + size) * (1 + cost) / best, rel=0.02)


def test_what_pays_is_left_as_it_is():
    random = np.random.default_rng(3)
    steps = np.stack([random.normal(size=20000), 3 * random.normal(size=20000)])
    assert roulette_limit(steps, np.ones(20000), np.ones(2)) == 1


def test_equal_paths_have_no_noise():
    assert roulette_limit(np.ones((2, 8)), np.ones(8), np.ones(2)) == 1


def test_parts_become_whole_lights():
    low = np.array([[0.0, 0, 0], [-np.inf] * 3])
    high = np.array([[1.0, 1, 0], [np.inf] * 3])
    plan = plan_slots(np.array([2, 4]), low, high)
    merged = whole(plan)
    assert merged.stock == pytest.approx([0.5, 0.5])
    slot = np.array([0, 3, 4, 19], np.uint32)
    nothing = np.zeros((4, 3))
    trials = Trials(np.arange(4, dtype=np.uint32), nothing, nothing, slot, plan.stock[slot], np.ones(4))
    found = of_whole_lights(trials, plan)
    assert found.slot.tolist() == [0, 0, 1, 1]
    assert found.chance == pytest.approx(0.5)
    assert found.given / found.chance == pytest.approx(trials.given / trials.chance)
