"""The exploring camera."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracer.core import sphere
from tracer.viewpoint import tour
from tracer.viewpoint.tour import carried, explore, smooth

STEP = np.radians(6)
UP = np.array([0.0, 0.0, 1.0])


def same(directions):
    """Return the same goodness for all views."""
    return np.ones(len(directions))


def test_where_all_views_are_alike_it_goes_straight_and_keeps_its_weight():
    found = explore(same, [1, 0, 0], 20, STEP)
    assert sphere.angle(found.directions[:-1], found.directions[1:]) == pytest.approx(np.full(20, STEP))
    assert sphere.angle(found.directions[0], found.directions[20]) == pytest.approx(20 * STEP)
    assert found.weights == pytest.approx(np.ones(21))
    assert found.length == pytest.approx(20 * STEP)


def test_it_turns_rather_than_come_back():
    found = explore(same, [1, 0, 0], 60, STEP)  # straight on it would be back
    assert sphere.angle(found.directions[60], found.directions[0]) > 1
    assert np.all(found.weights >= 0.5)


def test_a_chord_is_shorter_than_its_arc():
    found = explore(same, [1, 0, 0], 30, STEP, chord=True)
    assert np.all(found.weights <= 1)
    assert found.weights[-1] < 0.9


def test_visited_places_are_avoided_as_well():
    """Around a single good place the camera circles; it goes where it was only if it need not know."""
    best = np.array([1.0, 0, 0])

    def value(directions):
        return np.exp(20 * (directions @ best - 1))

    nearest = {}
    for avoided in ("start", "visited"):
        places = explore(value, best, 60, STEP, avoided=avoided).directions
        apart = sphere.angle(places[:, None], places[None])
        steps_between = np.abs(np.subtract.outer(np.arange(61), np.arange(61)))
        nearest[avoided] = apart[steps_between > tour.RECENT].min()
    assert nearest["visited"] > 1.5 * nearest["start"]
    straight = explore(same, best, 20, STEP, avoided="visited")
    assert straight.weights == pytest.approx(np.ones(21))
    assert sphere.angle(straight.directions[0], straight.directions[20]) == pytest.approx(20 * STEP)


@settings(deadline=None)  # how long it takes depends on what else the machine does
@given(st.integers(0, 10000))
def test_it_takes_the_best_of_three_smooth_ways(seed):
    peaks = sphere.normalised(np.random.default_rng(seed).normal(size=(4, 3)))
    asked = []

    def value(directions):
        asked.append(directions)
        return np.exp(3 * (directions @ peaks.T)).sum(axis=-1)

    found = explore(value, peaks[0], 25, STEP)
    assert [len(each) for each in asked] == [1, 8] + [3] * 24
    moves = sphere.normalised(np.diff(found.directions, axis=0))
    assert sphere.angle(moves[:-1], moves[1:]).max() < tour.TURN + STEP + 1e-6
    path = STEP * np.arange(1, 26)
    far = sphere.angle(found.directions[1:], found.directions[0])
    assert found.weights[1:] == pytest.approx(found.values[1:] / 2 * (1 + np.minimum(far / path, 1)))
    for k in range(2, 26):
        values = np.exp(3 * (asked[k] @ peaks.T)).sum(axis=-1)
        others = values / 2 * (1 + np.minimum(sphere.angle(asked[k], found.directions[0]) / (k * STEP), 1))
        assert found.weights[k] == pytest.approx(others.max())


def test_ways_on_turn_by_half_a_right_angle():
    """From the pole, heading along x: on, and half way to y and to -y; at first to all eight sides."""
    pole, half = np.array([0.0, 0, 1]), 0.5**0.5
    straight, *turned = tour.ways_on(pole, np.eye(3)[0])
    assert straight == pytest.approx([1, 0, 0])
    assert sorted(turned, key=lambda way: way[1]) == pytest.approx(np.array([[half, -half, 0], [half, half, 0]]))
    first = tour.ways_on(pole, None)
    turns = np.sort(np.degrees(np.arctan2(first[:, 1], first[:, 0])))
    assert np.diff(turns) == pytest.approx(np.full(7, 45))
    assert first[:, 2] == pytest.approx(np.zeros(8))


def test_it_moves_to_what_is_good():
    best = sphere.normalised([1.0, 1.0, 1.0])
    found = explore(lambda directions: 1 + directions @ best, [0, 0, -1], 15, STEP)
    assert np.all(np.diff(found.values) > 0)


def test_a_film_is_smooth_and_passes_through_all_places():
    found = explore(same, [1, 0, 0], 10, STEP)
    frames = smooth(found.directions, 101)
    assert frames[::10] == pytest.approx(found.directions, abs=1e-9)
    steps = sphere.angle(frames[:-1], frames[1:])
    assert steps.max() < 1.1 * steps.mean()
    assert smooth(found.directions[:1], 3) == pytest.approx(np.repeat(found.directions[:1], 3, axis=0))


def test_a_camera_that_passes_above_does_not_spin():
    turn = np.linspace(-1, 1, 41)
    directions = np.stack([np.sin(turn), 0 * turn + 1e-3, np.cos(turn)], axis=-1)
    views = carried(np.zeros(3), 5, sphere.normalised(directions), UP)
    assert sphere.angle(views.up[:-1], views.up[1:]).max() < 0.06
    basis = np.stack([views.right, views.up, -views.forward], axis=1)
    assert basis @ basis.transpose(0, 2, 1) == pytest.approx(np.broadcast_to(np.eye(3), (41, 3, 3)), abs=1e-9)
    assert np.linalg.det(basis) == pytest.approx(1)


@pytest.mark.parametrize("avoided", ["start", "visited"])
def test_a_loop_comes_back_and_is_no_way_there_and_back(avoided):
    found = explore(same, [1, 0, 0], 40, STEP, avoided=avoided, is_loop=True).directions
    assert sphere.angle(found[:-1], found[1:]).max() <= STEP * (1 + 1e-6)
    assert found[-1] == pytest.approx(found[0])
    assert sphere.angle(found, found[0]).max() > 0.6 * 40 * STEP / np.pi
    apart = sphere.angle(found[1:15, None], found[None, 25:-1])
    assert apart.min(axis=1).max() > 4 * STEP
    frames = smooth(found, 80, is_loop=True)
    around = np.concatenate([frames, frames[:1]])
    gaps = sphere.angle(around[:-1], around[1:])
    assert gaps.max() < 1.5 * gaps.mean()


def test_around_a_loop_the_picture_does_not_jump():
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    directions = sphere.normalised(np.stack([np.sin(turn), np.cos(turn), 0.7 + 0 * turn], axis=-1))
    views = carried(np.zeros(3), 5, directions, UP, is_loop=True)
    around = np.concatenate([views.up, views.up[:1]])
    assert sphere.angle(around[:-1], around[1:]).max() < 0.2
    assert np.abs(np.sum(views.up * views.forward, axis=1)).max() < 1e-12
