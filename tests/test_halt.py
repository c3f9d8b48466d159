"""When a render is over: whichever comes first."""

import time

import pytest

import tracer
from tracer.frame import PlainFrame
from tracer.halt import Clock, next_goal
from tracer.noise import Noise
from tracer.settings import make_settings

FRAME = PlainFrame((1, 1), 0, ["R", "G", "B"], 0, (0, 0, 1, 1))
GOALS = [400, 800, 1600]


def clock(limit=None, rate=None):
    found = Clock(limit, time.perf_counter(), FRAME)
    if rate is not None:
        found.samples, found.seconds = rate, 1.0
    return found


def test_goals_one_after_the_other():
    settings = make_settings(spp=16)
    assert next_goal(GOALS, 0, settings, None, clock()) == (400, None)
    assert next_goal(GOALS, 450, settings, None, clock()) == (800, None)
    assert next_goal(GOALS, 1600, settings, None, clock()) == (None, "spp")


def test_a_noise_target_ends_a_render_once_it_is_measured():
    settings = make_settings(noise=0.1)
    few, enough = 16 * 1600 // 4096 - 1, 400  # of 1600 for 4096 spp
    assert next_goal(GOALS, few, settings, Noise(0.05, 0.99, 1.0, True), clock()) == (400, None)
    assert next_goal(GOALS, enough, settings, Noise(0.05, 0.99, 1.0, False), clock()) == (800, None)
    assert next_goal(GOALS, enough, settings, Noise(0.05, 0.99, 1.0, True), clock()) == (None, "noise")
    assert next_goal(GOALS, 1600, settings, Noise(0.05, 0.99, 1.0, True), clock()) == (None, "noise")
    assert next_goal(GOALS, 1600, settings, Noise(0.2, 0.8, 4.0, True), clock()) == (None, "spp")
    assert next_goal(GOALS, enough, settings, Noise(0.2, 0.8, 4.0, True), clock()) == (800, None)
    assert next_goal(GOALS, enough, settings, Noise(0.12, 0.9, 1.44, True), clock()) == (round(400 * 1.05 * 1.44), None)


def test_time_shortens_a_round_and_ends_a_render():
    settings = make_settings(time=10.0, spp=16)
    goal, reason = next_goal(GOALS, 800, settings, None, clock(10.0, rate=20))
    assert (reason, 900 < goal < 1000) == (None, True)
    assert next_goal(GOALS, 800, settings, None, clock(10.0, rate=1)) == (None, "time")
    assert next_goal(GOALS, 800, settings, None, clock(0.0, rate=1e9)) == (None, "time")
    assert next_goal(GOALS, 0, settings, None, clock(0.0)) == (400, None)


@pytest.mark.parametrize("seconds", [0.01, 1.5])
def test_a_limit_of_time_gives_every_pixel_a_sample_and_ends_in_time(cornell, seconds):
    tracer.render(cornell(), size=64, spp=8)  # compiles
    start = time.perf_counter()
    result = tracer.render(cornell(), size=64, time=seconds)
    assert time.perf_counter() - start < seconds + 5
    assert result.report.stopped_by == "time"
    assert result.report.complete
    assert result.samples.min() >= 1
    assert seconds > 1 or result.samples.mean() <= 8
