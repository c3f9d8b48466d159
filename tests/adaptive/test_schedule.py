"""Rounds add up and grow slowly; passes are even and of the sizes that are meant."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer import criteria
from tracer.adaptive import prediction
from tracer.adaptive.schedule import GROWTH, PRIORITY_GROWTH, round_goals
from tracer.settings import make_settings

FUSED, MORE, GEOMETRY = (criteria.get(name) for name in ("fused", "luxcore", "shape_entropy"))


@pytest.mark.parametrize("criterion", [FUSED, MORE])
@given(spp=st.integers(1, 5000), pixels=st.integers(1, 10**7), unbiased=st.booleans())
def test_goals_end_at_the_budget_and_grow_slowly(criterion, spp, pixels, unbiased):
    goals = round_goals(make_settings(spp=spp, unbiased=unbiased), criterion, pixels)
    assert goals[-1] == spp * pixels
    assert goals == sorted(goals)
    if len(goals) > 1 and not unbiased:
        assert goals[0] == (8 if spp >= 16 and criterion is FUSED else 4) * pixels
        assert all(after <= GROWTH**1.5 * before + 1 for before, after in itertools.pairwise(goals))
    if unbiased and len(goals) > 1:
        assert len(goals) == 3
        assert goals[1] <= goals[2] / 8


@given(spp=st.integers(16, 5000))
def test_a_larger_budget_begins_in_the_same_way(spp):
    goals, more = (round_goals(make_settings(spp=budget), FUSED, 10) for budget in (spp, 2 * spp))
    assert more[: len(goals) - 1] == goals[:-1]


def test_a_limit_of_time_begins_with_one_sample():
    assert round_goals(make_settings(time=10.0, spp=32), FUSED, 10) == [10, 80, 160, 320]
    assert round_goals(make_settings(time=10.0, spp=16), MORE, 10) == [10, 40, 80, 160]
    assert round_goals(make_settings(time=10.0, spp=16, pilot_spp=1), FUSED, 10) == [10, 20, 40, 80, 160]
    assert round_goals(make_settings(noise=0.1, spp=16), GEOMETRY, 10) == [40, 80, 160]


def test_a_criterion_without_radiance_has_one_round():
    assert round_goals(make_settings(spp=64), GEOMETRY, 100) == [6400]


def test_a_budget_that_leaves_nothing_to_decide_has_one_round():
    assert round_goals(make_settings(spp=7), FUSED, 10) == [70]
    assert round_goals(make_settings(spp=8), FUSED, 10) == [40, 80]


def test_a_small_picture_of_many_shapes_has_one_round(monkeypatch):
    """Unless somebody asks for first samples, or for a limit that only rounds can keep."""
    monkeypatch.setattr(prediction, "WORK_OF_OBJECT", 450.0)
    small, large = 192 * 144, 800 * 600
    assert round_goals(make_settings(spp=64), FUSED, small, 2292) == [64 * small]
    assert len(round_goals(make_settings(spp=64), FUSED, small, 370)) == 4
    assert len(round_goals(make_settings(spp=64), FUSED, large, 2292)) == 4
    for settings in ({"pilot_spp": 8}, {"noise": 0.01}, {"unbiased": True}):
        assert len(round_goals(make_settings(spp=64, **settings), FUSED, small, 2292)) > 1
    assert len(round_goals(make_settings(spp=64), MORE, small, 2292)) > 1


def test_the_first_round_may_be_chosen():
    assert round_goals(make_settings(spp=32, pilot_spp=4), FUSED, 1) == [4, 8, 16, 32]


def test_only_the_last_round_grows_by_something_else():
    assert round_goals(make_settings(spp=12), FUSED, 1) == [4, 8, 12]
    assert round_goals(make_settings(spp=11), FUSED, 1) == [4, 11]
    assert round_goals(make_settings(spp=20), FUSED, 1) == [8, 20]


def test_by_priority_a_few_are_served_in_a_round():
    """Those that are served double what they have."""
    assert 0.1 < PRIORITY_GROWTH - 1 < 0.5
