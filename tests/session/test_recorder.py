"""Every second of a render is counted once."""

import numpy as np
import pytest

from tracer.core import stopwatch
from tracer.core.stopwatch import Seconds
from tracer.report import Report
from tracer.session.local_drawer import Pass
from tracer.session.recorder import Recorder
from tracer.session.state import State
from tracer.settings import make_settings


@pytest.fixture
def now(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(stopwatch, "read", lambda: Seconds(clock[0], 2 * clock[0]))
    return clock


def test_seconds_of_inner_blocks_are_not_those_of_outer_ones(now):
    found = Recorder(Report(make_settings()))
    with found.timing("seconds_deciding"):
        now[0] += 1.0
        with found.timing("seconds_pilot"):
            now[0] += 2.0
            with found.timing("seconds_denoising"):
                now[0] += 4.0
        now[0] += 8.0
    with found.timing("seconds_pilot"):
        now[0] += 16.0
    report = found.report
    assert (report.seconds_deciding, report.seconds_pilot, report.seconds_denoising) == (9.0, 18.0, 4.0)
    assert found.seconds == 31.0
    assert found.taken["seconds_deciding"] == Seconds(9.0, 18.0)


def test_a_block_that_fails_is_counted(now):
    found = Recorder(Report(make_settings()))

    def fail():
        with found.timing("seconds_pilot"):
            now[0] += 3.0
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    with found.timing("seconds_deciding"):
        now[0] += 1.0
    assert (found.report.seconds_pilot, found.report.seconds_deciding) == (3.0, 1.0)


def test_passes_and_rounds(now):
    found = Recorder(Report(make_settings()))
    drawn = np.array([[2, 2]], np.uint32)
    state = State(None, None, drawn)
    found.begin(state, ["remark"])
    found.add_pass(Pass(5, Seconds(1.5, 3.0), Seconds(0.25, 0.5)))
    found.add_round(state, np.array([[2, 7]], np.uint32), 2.0)
    assert (found.report.seconds_drawing, found.report.seconds_adding) == (1.5, 0.25)
    assert found.taken == {"seconds_drawing": Seconds(1.5, 3.0), "seconds_adding": Seconds(0.25, 0.5)}
    assert [(each.samples, each.least, each.most, each.seconds) for each in found.report.rounds] == [(5, 2, 7, 2.0)]
    assert found.report.notes == state.notes == ["remark"]
