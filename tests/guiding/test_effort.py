"""Learning goes on as long as that makes the picture better for its time."""

import numpy as np
import pytest

from tracer.guiding import effort
from tracer.guiding.effort import LearningCurve, block_length, is_worth_a_look, look_paths, pays


def learned(at_best, lack, total, doubt=0.0):
    """Learn where n paths leave the variance at_best + lack / n; return the numbers of paths, one for each time."""

    def left(path_count):
        return at_best + lack / path_count

    curve, count, counts = LearningCurve(), 1000, []
    while count:
        counts.append(sum(counts[-1:]) + count)
        curve.add(counts[-1], left(counts[-1]), left(counts[-2]) if len(counts) > 1 else 1.0, doubt)
        count = curve.further_paths(total)
        assert len(counts) < 40
    assert curve.left[-1][1] == pytest.approx(left(counts[-1]))
    return counts


def product(paths, at_best, lack, total):
    return (at_best + lack / paths) * (total + effort.LEARNING_COST * paths)


def curve_of(*added):
    curve = LearningCurve()
    for count, foretold, measured in added:
        curve.add(count, foretold, measured, 0.1)
    return curve


def test_a_look_that_promises_nothing_is_the_last():
    assert curve_of((1000, 1.0, 1.0)).further_paths(10**7) == 0
    assert curve_of((1000, 0.9, 1.0)).further_paths(10**7) == 1000


def test_it_ends_at_the_most_paths():
    curve, count, known = LearningCurve(most_paths=5000), 1000, 0
    while count:
        known += count
        curve.add(known, 500 / known, 500 / known, 0.1)
        count = curve.further_paths(10**9)
    assert known == 5000


def test_a_promise_that_is_not_kept_ends_it():
    """What is measured counts, and not what was foretold."""
    curve = curve_of((1000, 0.2, 1.0), (2000, 0.2, 1.1))
    assert curve.further_paths(10**7) == 0
    assert curve.gain() < 1
    kept = curve_of((1000, 0.9, 1.0), (2000, 0.8, 0.3))
    assert kept.left == [(1000, 0.3), (2000, pytest.approx(0.3 * 0.8 / 0.9))]
    assert kept.gain() == pytest.approx(1 / kept.left[-1][1])
    assert kept.believed_gain(2) == pytest.approx(np.exp(-0.1) * kept.gain())
    assert kept.believed_gain(effort.MANY_LIGHTS) == kept.gain()


@pytest.mark.parametrize("lack", [30.0, 100.0, 300.0])
@pytest.mark.parametrize("total", [10**4, 10**5, 10**6])
def test_it_ends_near_the_best_number(lack, total):
    """One step less or more would be worse, or better by no more than what is asked of a step."""
    counts = learned(0.2, lack, total)
    last = counts[-1]
    found = product(last, 0.2, lack, total)
    assert last < effort.MOST_PATHS / effort.MORE
    assert product(effort.MORE * last, 0.2, lack, total) * effort.WORTH_MORE >= found
    if len(counts) > 2:
        assert product(counts[-2], 0.2, lack, total) >= effort.WORTH_MORE * found
    assert np.all(np.diff(counts) > 0)


def test_it_ends_at_the_most():
    counts = learned(0.0, 900.0, 10**9)
    assert 0.9 * effort.MOST_PATHS < counts[-1] <= effort.MOST_PATHS


@pytest.mark.parametrize(("total", "count"), [(10**3, 20), (10**5, 2000), (10**6, 1 << 14), (10**7, 75000)])
def test_the_look_is_a_small_part(total, count):
    assert look_paths(total) == count
    assert look_paths(10**10) == effort.MOST_LOOK_PATHS


def test_blocks_are_as_long_as_the_picture_has_samples_if_there_are_enough_pixels():
    assert block_length(1 << 18, 64) == 64
    assert block_length(1 << 18, 48) == 32
    assert block_length(1 << 18, 4) == 4
    assert block_length(1 << 14, 64) == 32
    assert block_length(100, 64) == 1


def test_a_picture_pays_for_learning_that_it_is_large_enough_for():
    assert pays(1.5, 1 << 20, 1 << 14)
    assert not pays(1.4, 1 << 20, 1 << 14)
    assert not pays(1.0, 1 << 30)
    assert pays(1.25, 1 << 18)


@pytest.mark.parametrize(
    ("light_count", "total", "is_worth_it"),
    [(0, 10**9, False), (2, 2 * 10**6, False), (2, 10**7, True), (40, 2 * 10**6, True), (40, 10**5, False)],
)
def test_a_look_is_for_large_pictures_or_many_lights(light_count, total, is_worth_it):
    assert is_worth_a_look(total, light_count) == is_worth_it
