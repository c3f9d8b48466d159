"""Weights of two techniques."""

import mitsuba as mi
import pytest

from tracer.guiding.mis import power_heuristic


def test_weights_of_both_techniques_sum_to_one_in_proportion_to_squares():
    one, other = mi.Float([1.0, 3.0, 0.0]), mi.Float([2.0, 1.0, 5.0])
    assert power_heuristic(one, other).numpy() == pytest.approx([1 / 5, 9 / 10, 0])
    assert (power_heuristic(one, other) + power_heuristic(other, one)).numpy() == pytest.approx([1, 1, 1])


def test_what_neither_draws_has_no_weight():
    assert power_heuristic(mi.Float(0.0), mi.Float(0.0)).numpy() == [0.0]
