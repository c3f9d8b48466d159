"""Predicted gains are those of Neyman's rule, and a decision is taken to cost what it costs."""

from dataclasses import replace
from types import SimpleNamespace

import mitsuba as mi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tracer.adaptive import prediction
from tracer.adaptive.decision import Situation
from tracer.adaptive.prediction import predicted_gain, predicted_overhead
from tracer.core.device import upload

positive = hnp.arrays(np.float64, (9,), elements=st.floats(0.01, 100))


def gain(deviation, share, cost):
    """Return the gain over uniform sampling."""
    return predicted_gain(*(upload(mi.Float64, values) for values in (share, np.ones(9), deviation, cost)))


@given(deviation=positive)
def test_predicted_gain_is_one_plus_squared_variation(deviation):
    variation = deviation.std() / deviation.mean()
    assert gain(deviation, deviation, np.full(9, 3.0)) == pytest.approx(1 + variation**2)
    assert gain(deviation, np.full(9, 2.0), np.ones(9)) == pytest.approx(1)
    assert gain(np.zeros(9), deviation, np.ones(9)) == 1


@given(deviation=positive, cost=positive)
def test_what_is_predicted_is_gained_and_most_by_the_best_allocation(deviation, cost):
    uniform = (deviation**2).sum() * cost.sum()
    best = gain(deviation, deviation / np.sqrt(cost), cost)
    for counts in (deviation, np.sqrt(deviation), 1 / cost, deviation**2, np.ones(9)):
        gained = uniform / ((deviation**2 / counts).sum() * (counts * cost).sum())
        assert gain(deviation, counts, cost) == pytest.approx(gained)
        assert gained <= best * (1 + 1e-9)


@pytest.mark.parametrize(("size", "milliseconds"), [((144, 192), (16, 23)), ((512, 512), (85, 95))])
def test_a_decision_is_taken_to_cost_what_it_was_measured_to_cost(size, milliseconds, work_of_decision, monkeypatch):
    """With two threads, where the unit takes 60 to 250 ns; over the samples for which it holds."""
    monkeypatch.setattr(prediction, "WORK_OF_DECISION", work_of_decision)
    pixels, statistics = size[0] * size[1], SimpleNamespace(work=np.full(size, 4.0))
    now = Situation(np.full(size, 4, np.uint32), 8 * pixels, 32 * pixels, may_settle=True)
    rays = predicted_overhead(statistics, now) * 4 * 32 * pixels
    assert milliseconds[0] / 250e-6 < rays < milliseconds[1] / 60e-6
    monkeypatch.setattr(prediction, "WORK_OF_OBJECT", 450.0)
    more = predicted_overhead(statistics, replace(now, object_count=2292)) * 4 * 32 * pixels - rays
    assert more == pytest.approx(180e-3 / 186e-9, rel=0.1)  # measured in thousand_lamps
    monkeypatch.setattr(prediction, "WORK_OF_OBJECT", 0.0)
    shorter = predicted_overhead(statistics, replace(now, horizon=8 * pixels))
    assert shorter == pytest.approx(4 * predicted_overhead(statistics, now))


def test_in_a_small_picture_hardly_a_decision_pays(work_of_decision, monkeypatch):
    monkeypatch.setattr(prediction, "WORK_OF_DECISION", work_of_decision)
    statistics = SimpleNamespace(work=np.full((8, 8), 4.0))
    now = Situation(np.full((8, 8), 4, np.uint32), 8 * 64, 32 * 64, may_settle=True)
    assert predicted_overhead(statistics, now) > 10
