"""Keep Python from collecting garbage at the wrong moment."""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator
from contextlib import contextmanager

lock = threading.Lock()
pauses = 0
"""Number of pauses under way, in all threads."""
resumes = True
"""Whether collections go on when the last pause ends."""


@contextmanager
def no_collection() -> Iterator[None]:
    """Collect no garbage in the block, unless Python did not do so before either.

    Dr.Jit ends the process if a scene is freed while a function is recorded.
    """
    global pauses, resumes
    with lock:
        if pauses == 0:
            resumes = gc.isenabled()
            gc.disable()
        pauses += 1
    try:
        yield
    finally:
        with lock:
            pauses -= 1
            if pauses == 0 and resumes:
                gc.enable()
