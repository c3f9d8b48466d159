"""Ctrl-C and SIGTERM: end the work and keep the results so far."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

HANDLED = (signal.SIGINT, signal.SIGTERM)
"""Signals that are handled."""
REPEATED_SECONDS = 1.0
"""Seconds within which signals count as a single one: a terminal sends a signal to all processes of a command."""

received: int | None = None
"""Number of the signal that stopped the program."""


def exit_code() -> int:
    """Return the exit code of a program that was stopped: 130 or 143."""
    return 128 + (received or signal.SIGINT)


@contextmanager
def interrupting() -> Iterator[None]:
    """Turn signals within the block into KeyboardInterrupt."""

    def interrupt() -> None:
        raise KeyboardInterrupt

    with handling(interrupt):
        yield


@contextmanager
def stopping() -> Iterator[Callable[[], bool]]:
    """Turn a first signal into a flag, which the yielded function returns, and a second into KeyboardInterrupt."""
    stopped = False

    def stop() -> None:
        nonlocal stopped
        if stopped:
            raise KeyboardInterrupt
        stopped = True

    with handling(stop):
        yield lambda: stopped


@contextmanager
def handling(action: Callable[[], None]) -> Iterator[None]:
    """Call ``action`` for every signal within the block; outside the main thread signals are not handled."""
    last = float("-inf")

    def handle(signal_number: int, frame: Any) -> None:
        global received
        nonlocal last
        before, last = last, time.monotonic()
        received = received or signal_number
        if last - before > REPEATED_SECONDS:
            action()

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    previous = [signal.signal(signal_number, handle) for signal_number in HANDLED]
    try:
        yield
    finally:
        for signal_number, handler in zip(HANDLED, previous, strict=True):
            signal.signal(signal_number, handler)
