"""Seconds of kernels and of work on arrays are shared by threads; what Python does by itself is not."""

import time

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from benchmarks.time.alone import seconds_shared
from tracer.core import parallel
from tracer.sampling import passes

PAUSE = 0.3
"""Seconds in which a single thread waits."""


def heavy() -> None:
    """Run a kernel of about a tenth of a second."""
    number = dr.arange(mi.Float, 1 << 22)
    loop = dr.while_loop((mi.UInt32(0), number), lambda k, x: k < 60, lambda k, x: (k + 1, dr.sin(x)))
    dr.eval(loop[1])
    dr.sync_thread()


def work_on_arrays(seconds: float) -> None:
    """Let an element-wise function take this long."""

    def wait(rows: np.ndarray) -> np.ndarray:
        time.sleep(seconds)
        return rows

    parallel.fill(np.empty(parallel.LEAST_ENTRIES), wait, np.ones(parallel.LEAST_ENTRIES))


@pytest.mark.parametrize("shares", [heavy, lambda: work_on_arrays(PAUSE)])
def test_what_threads_share_is_told_from_what_one_does(shares):
    def way(spp: int, seed: int) -> dict:
        assert passes.next_pass_size(1.0, 0) == passes.PASS_SIZES[-1]
        shares()
        time.sleep(PAUSE)
        return {}

    seconds, shared = seconds_shared(way, 4)
    assert 0 < shared < seconds
    assert seconds - shared == pytest.approx(PAUSE, rel=0.2)
