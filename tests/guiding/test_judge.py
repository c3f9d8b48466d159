"""A verdict is the second moment that a choice would have, by trials that had no part in it."""

import numpy as np
import pytest

from tracer.guiding.judge import Verdict, judge, sure_rows


def test_it_is_the_second_moment_of_the_choice():
    """Two lights, of which one gives 1: chosen half of the time the second moment is 2, and chosen always it is 1."""
    stock, chances = np.array([0.5, 0.5]), np.array([[1 - 1e-9, 1e-9], [0.25, 0.75]])
    random = np.random.default_rng(0)
    row, slot = random.integers(0, 2, 100_000), random.integers(0, 2, 100_000)
    squares = np.array([1.0, 0])[slot]
    verdict = judge(chances, stock, row, slot, squares / stock[slot])
    per_trial = np.bincount(row)
    assert np.allclose(verdict.stock / per_trial, 2, rtol=0.02)
    assert np.allclose(verdict.guided / per_trial, [1, 4], rtol=0.02)


def test_chances_by_chance_are_not_sure_to_gain():
    """What was learned from noise is judged by other noise: hardly a row gains."""
    random = np.random.default_rng(1)
    stock, count = np.full(8, 1 / 8), 400
    chances = random.dirichlet(np.ones(8) * 3, count)
    row, slot = random.integers(0, count, 100_000), random.integers(0, 8, 100_000)
    verdict = judge(chances, stock, row, slot, random.exponential(size=100_000) / stock[slot])
    assert sure_rows(verdict, np.arange(count) // 16, 1.05, 1.0).mean() < 0.02


def test_a_row_with_few_trials_follows_its_group():
    stock, guided = np.array([100.0, 100, 1e-3]), np.array([50.0, 50, 2e-3])
    assert sure_rows(Verdict(stock, guided), np.zeros(3, int), 1.05, 1.0).tolist() == [True] * 3
    assert sure_rows(Verdict(stock, guided), np.array([0, 0, 1]), 1.05, 1.0).tolist() == [True, True, False]


def test_verdicts_add_up():
    total = Verdict(np.ones(2), np.zeros(2)) + Verdict(np.ones(2), np.ones(2))
    assert total.stock.tolist() == [2, 2]
    assert total.guided.tolist() == pytest.approx([1, 1])
