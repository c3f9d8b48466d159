"""Seconds on the clock and of the processor are read together."""

from tracer.core import stopwatch


def test_both_clocks_run():
    start = stopwatch.read()
    while (taken := stopwatch.read() - start).cpu == 0.0:
        pass
    assert taken.wall > 0.0
    assert (taken + taken).cpu == 2 * taken.cpu
