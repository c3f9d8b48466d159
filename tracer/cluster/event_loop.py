"""The thread in which Dask talks to others, also on a machine that is for a while too busy to start it."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from distributed.utils import LoopRunner

from tracer.errors import ClusterError

logger = logging.getLogger(__name__)

MOST_STARTS = 3
"""How often a start is tried. Dask waits ten seconds for each."""


@contextmanager
def event_loop() -> Iterator[Any]:
    """Run an event loop of tornado in a thread of its own. Raises ClusterError if it does not start."""
    runner = start()
    try:
        yield runner.loop
    finally:
        try:
            runner.stop()
        except TimeoutError:  # the thread does not keep the program from ending
            logger.debug("Dask's event loop does not end.")


def start() -> Any:
    """Return a runner whose event loop runs. Raises ClusterError."""
    for _ in range(MOST_STARTS):
        runner = LoopRunner()
        try:
            runner.start()
        except AssertionError:  # what Dask raises where the thread has not begun after ten seconds
            logger.debug("Dask's event loop has not started.")
        else:
            return runner
    raise ClusterError(f"Dask's event loop did not start in {MOST_STARTS} attempts; this machine is too busy.")
