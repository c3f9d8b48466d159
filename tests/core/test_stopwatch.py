"""Seconds on the clock and of the processor tell how long one thread worked alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.core import stopwatch
from tracer.core.stopwatch import Seconds


@given(st.floats(0, 100), st.floats(0, 100), st.integers(2, 64))
def test_serial_seconds_are_found(alone, together, threads):
    taken = Seconds(wall=alone + together, cpu=alone + threads * together)
    assert taken.serial(threads) == pytest.approx(alone, abs=1e-9)


def test_they_are_within_the_seconds_on_the_clock():
    assert Seconds(1.0, 3.0).serial(2) == 0.0  # more than two threads can have worked
    assert Seconds(1.0, 0.0).serial(2) == 1.0  # it waited


def test_both_clocks_run():
    start = stopwatch.read()
    while (taken := stopwatch.read() - start).cpu == 0.0:
        pass
    assert taken.wall > 0.0
    assert (taken + taken).cpu == 2 * taken.cpu
