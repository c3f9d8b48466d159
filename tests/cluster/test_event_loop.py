"""Dask's event loop starts, at the second attempt if need be, and ends with the block."""

import threading

import pytest
from distributed.utils import LoopRunner

from tracer.cluster.event_loop import MOST_STARTS, event_loop
from tracer.errors import ClusterError


@pytest.fixture
def failing(monkeypatch):
    """Return a list; as many starts fail as it has elements."""
    left: list[None] = []
    begin = LoopRunner.start

    def start(runner):
        if left:
            left.pop()
            raise AssertionError
        begin(runner)

    monkeypatch.setattr(LoopRunner, "start", start)
    return left


@pytest.mark.parametrize("failures", [0, 1, 2])
def test_it_runs_in_the_block_only(failing, failures):
    failing.extend([None] * failures)
    with event_loop() as loop:
        ran = threading.Event()
        loop.add_callback(ran.set)
        assert ran.wait(60)
    assert not loop.asyncio_loop.is_running()


def test_a_machine_that_stays_too_busy_is_a_sentence(failing):
    failing.extend([None] * MOST_STARTS)
    with pytest.raises(ClusterError, match="this machine is too busy"), event_loop():
        pass
