"""How far a render is: forward only, whatever the noise turns out to be, and at the end only at the end."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tracer
from tracer.adaptive.convergence import Noise
from tracer.adaptive.stopping import LEAST_SPP, Clock
from tracer.progress import MOST_UNFINISHED, Course, Progress
from tracer.scene.frame import PlainFrame

FRAME = PlainFrame((10, 10), 0, ["R", "G", "B"], 0, (0, 0, 10, 10))
PIXELS = 100
BOUND = 4096 * PIXELS


def course(total=BOUND, limit=None):
    return Course(Clock(limit, time.perf_counter(), FRAME.pixel_count), total, PIXELS)


def noise(needed):
    return Noise(0.05 * needed**0.5, 0.9, needed, True)


def told(found, rounds, passes=4):
    """Return (samples, fraction) after every pass of rounds that end at some samples and find so many times needed."""
    before, said = 0, []
    for done, needed in rounds:
        for samples in np.linspace(before, done, passes + 1)[1:].astype(int):
            said.append((int(samples), found.fraction(int(samples), done)))
        found.measured(noise(needed), done)
        before = done
    return said


def test_a_budget_is_the_part_of_its_samples():
    found = course(total=1000)
    assert [found.fraction(done, 1000) for done in (0, 250, 700)] == [0, 0.25, 0.7]
    assert found.fraction(1000, 1000) == MOST_UNFINISHED


RECORDED = [(4, 4.1), (8, 2.0), (16, 1.72), (32, 1.05), (40, 2.08), (80, 1.07)]
"""Samples per pixel after each round of a noise target, and how many times as many it was then found to take. Over the
expected total of the moment that is 58, 95, 48 and 93 %."""


def test_a_noise_target_that_is_found_further_away_does_not_move_the_bar_back():
    said = told(course(), [(PIXELS * spp, needed) for spp, needed in RECORDED])
    fractions = [fraction for _, fraction in said]
    assert fractions == sorted(fractions)
    assert fractions[-1] < 1
    by_samples = dict(said)
    # 16 samples: at most half of what was left of 8 of 16; 32: of 1/1.72; 80: no more than when it was nearest.
    assert by_samples[1600] == pytest.approx(0.75)
    assert by_samples[3200] == pytest.approx(0.5 + 0.5 / 1.72)
    assert by_samples[8000] == pytest.approx(max(0.5 + 0.5 / 1.05, 0.5 + 0.5 / 2.08))


@given(
    st.lists(st.tuples(st.integers(4, 1000), st.floats(1, 1e6)), min_size=1, max_size=12),
    st.one_of(st.none(), st.floats(0.001, 1e4)),
)
def test_a_fraction_never_falls_and_is_whole_only_at_the_end(steps, limit):
    done, rounds = 0, []
    for more, needed in steps:
        done += more
        rounds.append((done, needed))
    total = max(done, BOUND // 50)
    found = course(total=total, limit=limit)
    fractions = [fraction for _, fraction in told(found, rounds)]
    assert fractions == sorted(fractions)
    assert fractions[0] > 0
    assert fractions[-1] <= MOST_UNFINISHED
    for samples, needed in rounds:
        found.measured(noise(needed), samples)
        assert max(samples, min(LEAST_SPP * PIXELS, total)) <= found.expected(samples, samples) <= total


def test_a_limit_of_time_is_the_part_of_it_that_is_over(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
    found = course(limit=10.0)
    span = found.clock.end - 100.0
    now[0] += 0.25 * span
    assert found.fraction(10, 400) == pytest.approx(0.25)
    found.clock.passed(10)  # in a quarter of the time
    assert found.seconds_left(10, 400) == pytest.approx(0.75 * span)  # and not the hours that all samples would take
    now[0] += span
    assert found.fraction(20, 400) == MOST_UNFINISHED
    assert found.seconds_left(20, 400) == 0


def test_words_name_a_total_only_where_it_is_certain():
    assert Progress(6144, 12288, 1.0).in_words() == "6.14 k of 12.3 k samples"
    assert Progress(6144, 12288, 1.0, converged=0.9996, is_open=True).in_words() == "6.14 k samples, 99 % converged"


@pytest.mark.parametrize("settings", [{"spp": 32}, {"noise": 0.05, "spp": 128}, {"noise": 0.2}, {"time": 1.0}])
def test_a_render_tells_of_its_end(cornell, monkeypatch, settings):
    monkeypatch.setattr("tracer.sampling.passes.PASS_SIZES", (700, 700, 700))
    monkeypatch.setattr("tracer.session.local_drawer.PASS_SIZES", (700, 700, 700))
    seen = []
    result = tracer.render(cornell(), progress=seen.append, **settings)
    fractions = [now.fraction for now in seen]
    assert len(seen) > (1 if "time" in settings else 4)  # a busy machine has time for few
    assert fractions == sorted(fractions)
    assert fractions[-2] < 1 == fractions[-1]
    assert [now.finished for now in seen] == [False] * (len(seen) - 1) + [True]
    assert seen[-1].done == seen[-1].total == round(result.report.spp * 384)
    assert seen[-1].remaining == 0
    assert np.array_equal(seen[-1].image, result.image)
    assert np.array_equal(seen[-1].samples, result.samples)
    assert all(now.is_open == ("spp" not in settings or "noise" in settings) for now in seen)
    assert (seen[-1].converged is None) == ("noise" not in settings)


def test_a_render_that_was_stopped_is_not_whole_at_its_end(cornell):
    seen = []
    tracer.render(cornell(), spp=64, progress=lambda now: seen.append(now) or len(seen) < 2)
    assert seen[-1].finished
    assert seen[-1].fraction == seen[-2].fraction == seen[-1].done / (64 * 384) < 1
