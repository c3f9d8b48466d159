"""Rounds add up and grow slowly; passes are even and of the sizes that are meant."""

import itertools

from hypothesis import given
from hypothesis import strategies as st

from tracer.adaptive.schedule import GROWTH, PRIORITY_GROWTH, round_goals
from tracer.settings import make_settings


@given(spp=st.integers(1, 5000), pixels=st.integers(1, 10**7), unbiased=st.booleans())
def test_goals_end_at_the_budget_and_grow_slowly(spp, pixels, unbiased):
    goals = round_goals(make_settings(spp=spp, unbiased=unbiased), True, pixels)
    assert goals[-1] == spp * pixels
    assert goals == sorted(goals)
    if len(goals) > 1 and not unbiased:
        assert goals[0] == 4 * pixels
        assert all(after <= GROWTH**1.5 * before + 1 for before, after in itertools.pairwise(goals))
    if unbiased and len(goals) > 1:
        assert len(goals) == 3
        assert goals[1] <= goals[2] / 8


@given(spp=st.integers(8, 5000))
def test_a_larger_budget_begins_in_the_same_way(spp):
    goals, more = (round_goals(make_settings(spp=budget), True, 10) for budget in (spp, 2 * spp))
    assert more[: len(goals) - 1] == goals[:-1]


def test_a_limit_of_time_begins_with_one_sample():
    assert round_goals(make_settings(time=10.0, spp=16), True, 10) == [10, 40, 80, 160]
    assert round_goals(make_settings(time=10.0, spp=16, pilot_spp=1), True, 10) == [10, 20, 40, 80, 160]
    assert round_goals(make_settings(noise=0.1, spp=16), False, 10) == [40, 80, 160]


def test_a_criterion_without_radiance_has_one_round():
    assert round_goals(make_settings(spp=64), False, 100) == [6400]


def test_a_budget_that_leaves_nothing_to_decide_has_one_round():
    assert round_goals(make_settings(spp=7), True, 10) == [70]
    assert round_goals(make_settings(spp=8), True, 10) == [40, 80]


def test_only_the_last_round_grows_by_something_else():
    assert round_goals(make_settings(spp=12), True, 1) == [4, 8, 12]
    assert round_goals(make_settings(spp=11), True, 1) == [4, 11]


def test_by_priority_a_few_are_served_in_a_round():
    """Those that are served double what they have."""
    assert 0.1 < PRIORITY_GROWTH - 1 < 0.5
