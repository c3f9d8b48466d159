"""Samples shared out: the least that everyone has, and chances that are those stated."""

import numpy as np
import pytest
from scipy import stats

from tracer.adaptive.decision import Situation
from tracer.adaptive.sharing import least_counts, share_out, share_out_with_chances
from tracer.settings import make_settings

GRID = (8, 8)


def situation(drawn, goal, total=None):
    return Situation(drawn.astype(np.uint32), goal, goal if total is None else total, may_settle=True)


def test_least_counts_ask_for_no_more_than_there_is():
    """Half of the pixels have far more than their share, as where a round was stopped."""
    drawn = np.zeros(GRID)
    drawn[: GRID[0] // 2] = 100
    now = situation(drawn, int(drawn.sum()) + 20)
    least = least_counts(np.ones(GRID), make_settings(spp=100, min_spp=50), now, 1).numpy().reshape(GRID)
    assert np.all(least >= drawn)
    assert least.sum() <= now.goal
    counts = share_out(np.ones(GRID), np.ones(GRID), make_settings(spp=100), now, True, np.random.default_rng(0))
    assert counts.sum() == now.goal
    assert np.all(counts >= drawn)


def test_the_least_grows_with_what_is_drawn():
    settings, nothing = make_settings(spp=64), np.zeros(GRID)
    for spp, expected in ((8, 1), (20, 2), (32, 4), (64, 8)):  # 8 samples times the part of the budget, whole ones
        least = least_counts(np.ones(GRID), settings, situation(nothing, spp * 64, 64 * 64), 8)
        assert np.all(least.numpy() == expected)


@pytest.mark.slow
@pytest.mark.parametrize("goal", [96 * 8, 96 * 5 + 17])
def test_chances_are_those_that_pixels_have(goal):
    """A pixel that has a sample counts 1 / chance times, and so once on average, whoever it is (Horvitz, Thompson)."""
    importance = np.random.default_rng(1).lognormal(0, 1.2, (8, 12))
    drawn = np.where(importance > 1, 4, 5).astype(np.uint32)
    settings = make_settings(spp=16)
    now = Situation(drawn, max(goal, int(drawn.sum()) + 60), 96 * 16, may_settle=True)
    rounds = 2000
    weights = []
    for seed in range(rounds):
        found = share_out_with_chances(importance, np.ones((8, 12)), settings, now, np.random.default_rng(seed))
        more = found.allocation.astype(int) - drawn
        assert more.min() >= 0
        assert found.allocation.sum() == now.goal
        weights.append(np.where(more > 0, 1 / np.maximum(found.chance, 1e-9), 0))
        assert np.all(found.chance[more > 0] > 0)
    mean, spread = np.mean(weights, axis=0), np.std(weights, axis=0) / np.sqrt(rounds)
    limit = stats.norm.ppf(1 - (1 - (1 - 1e-3) ** (1 / 96)) / 2)  # Sidak: a false alarm in a thousand
    assert np.all(abs(mean - 1) <= limit * spread + 1e-9)
    assert np.mean(spread > 0) > 0.1


def test_a_round_without_room_leaves_nothing_to_chance():
    importance = np.random.default_rng(1).lognormal(0, 1, (8, 12))
    drawn = np.full((8, 12), 4, np.uint32)
    for least, more in ((None, 3), (8, 96 * 4)):
        settings = make_settings(spp=16, min_spp=least)
        now = Situation(drawn, 96 * 4 + more, 96 * 8 if least else 96 * 16, may_settle=True)
        found = share_out_with_chances(importance, np.ones((8, 12)), settings, now, np.random.default_rng(0))
        assert found.allocation.sum() == now.goal
        assert np.array_equal(found.chance, found.allocation > drawn)
