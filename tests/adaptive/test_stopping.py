"""When a render is over: whichever comes first."""

import time
from types import SimpleNamespace

import pytest

import tracer
from tracer.adaptive import stopping
from tracer.adaptive.convergence import Noise
from tracer.adaptive.stopping import SECONDS_PER_PIXEL, SECONDS_TO_END, Clock, next_goal
from tracer.scene.frame import PlainFrame
from tracer.settings import make_settings

FRAME = PlainFrame((1, 1), 0, ["R", "G", "B"], 0, (0, 0, 1, 1))
GOALS = [400, 800, 1600]


def clock(limit=None, rate=None):
    found = Clock(limit, time.perf_counter(), FRAME.pixel_count)
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


def seconds_to_render(scene, **settings):
    start = time.perf_counter()
    result = tracer.render(scene, size=64, **settings)
    return time.perf_counter() - start, result


@pytest.mark.parametrize("enough", [False, True])
def test_a_limit_of_time_gives_every_pixel_a_sample_and_ends_in_time(cornell, enough):
    tracer.render(cornell(), size=64, spp=8)  # compiles
    usual, _ = seconds_to_render(cornell(), spp=8)
    seconds = 1.5 + 10 * usual if enough else 0.01  # as slow as the machine is
    took, result = seconds_to_render(cornell(), time=seconds)
    assert took < seconds + 5 + 10 * usual
    assert result.report.stopped_by == "time"
    assert result.report.complete
    assert result.samples.min() >= 1
    assert (result.samples.mean() > 8) == enough


@pytest.fixture
def now(monkeypatch):
    """Return a clock that goes as a test lets it go: seconds, in a list of one."""
    seconds = [100.0]
    monkeypatch.setattr(stopping, "time", SimpleNamespace(perf_counter=lambda: seconds[0]))
    return seconds


def passes(found, now, *several):
    for samples, seconds in several:
        now[0] += seconds
        found.passed(samples)
    return found


def test_the_first_pass_says_nothing_of_the_others_and_later_ones_count_more(now):
    found = Clock(None, now[0], FRAME.pixel_count)
    assert found.seconds_for(10) is None
    assert passes(found, now, (1000, 10.0)).seconds_for(500) == pytest.approx(5.0)
    assert passes(found, now, (1000, 1.0)).seconds_for(500) == pytest.approx(0.5)
    # Of three passes the last has weight 1 and the one before 0.8: (1 + 0.8) s for 3000 + 800 samples.
    assert passes(found, now, (3000, 1.0)).seconds_for(3800) == pytest.approx(1.8)


def test_what_fits_in_the_time_that_is_left(now):
    limited = passes(Clock(60.0, now[0], FRAME.pixel_count), now, (500, 9.0), (500, 1.0))
    left = 50.0 - SECONDS_TO_END - SECONDS_PER_PIXEL
    assert limited.samples_left() == pytest.approx(500 * left)
    limited.keep_back(10.0)
    assert limited.samples_left() == pytest.approx(500 * (left - 10))
    assert Clock(None, now[0], FRAME.pixel_count).samples_left() == float("inf")


def test_a_large_picture_keeps_back_the_time_to_write_it(now):
    """Of a megapixel 2 s, by the measured 2 microseconds a pixel."""
    large = PlainFrame((1000, 1000), 0, ["R", "G", "B"], 0, (0, 0, 1000, 1000))
    ends = [Clock(60.0, now[0], frame.pixel_count).end for frame in (FRAME, large)]
    assert ends[0] - ends[1] == pytest.approx(2.0, rel=1e-3)


def test_no_pass_is_begun_that_would_end_too_late(now):
    limited = passes(Clock(20.0, now[0], FRAME.pixel_count), now, (500, 4.0))
    assert not limited.is_over()
    now[0] = 100 + 20 - 4.5
    assert not limited.is_over()
    now[0] = 100 + 20 - 3.5
    assert limited.is_over()


def test_a_round_is_planned_for_nine_tenths_of_the_time_that_is_left(now):
    settings = make_settings(time=30.0, spp=16)
    limited = passes(Clock(30.0, now[0], FRAME.pixel_count), now, (50, 9.0), (10, 1.0))
    left = 10 * (20.0 - SECONDS_TO_END - SECONDS_PER_PIXEL)
    assert next_goal(GOALS, 810, settings, None, limited) == (810 + int(0.9 * left), None)
    # another round is worth while for a twentieth of the samples there are
    assert next_goal([10**6], int(19 * left), settings, None, limited)[1] is None
    assert next_goal([10**6], int(21 * left), settings, None, limited) == (None, "time")


def test_a_noise_target_that_is_nearly_met_asks_for_a_fifth_more(now):
    settings = make_settings(noise=0.1)
    nearly, met = Noise(0.1001, 0.94, 1.002, True), Noise(0.1, 0.95, 1.0, True)
    assert next_goal(GOALS, 500, settings, nearly, clock()) == (600, None)
    assert next_goal(GOALS, 500, settings, met, clock()) == (None, "noise")


def test_a_noise_target_is_not_met_before_sixteen_samples_a_pixel():
    settings, met = make_settings(noise=0.1, spp=64), Noise(0.05, 0.99, 1.0, True)
    goals = [400, 800, 6400]  # of 100 pixels
    assert next_goal(goals, 1599, settings, met, clock()) == (6400, None)
    assert next_goal(goals, 1600, settings, met, clock()) == (None, "noise")


def test_a_render_that_goes_on_draws_before_it_knows_its_rate():
    """Of a checkpoint no pass has been timed; only if no time is left does it end at once."""
    settings = make_settings(time=30.0, spp=16)
    assert next_goal(GOALS, 800, settings, None, clock(30.0)) == (next(goal for goal in GOALS if goal > 800), None)
    assert next_goal(GOALS, 800, settings, None, clock(0.0)) == (None, "time")
