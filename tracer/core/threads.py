"""Threads for files: enough of them in Dr.Jit's pool wherever Mitsuba may read or write an EXR file.

Mitsuba hands the blocks of an EXR file to the workers of the pool, and waits until they are done without a hand in it.
The thread that waits counts as one of the pool: a pool of one has no worker, and the wait has no end. A file that is
written asynchronously, as ``mi.util.write_bitmap`` does unless told otherwise, occupies a worker that waits in the same
way. So a pool needs one thread more than there are EXR files under way, and one at least to read the next.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache

import drjit as dr
import mitsuba as mi

from tracer.errors import PendingWriteError

COUNT = 4
"""For one file, and two more that somebody else has begun to write. To start and end threads takes 0.1 to 0.4 ms."""


@dataclass
class Extended:
    """The pool while any block of ``for_files`` is open, in whatever thread."""

    blocks: int = 0
    own_count: int | None = None
    """Threads that the pool had before, None while it is as somebody else has set it."""


extended = Extended()
lock = threading.Lock()


@contextmanager
def for_files() -> Iterator[None]:
    """Keep at least COUNT threads in the pool within the block, then as many as there were before.

    Files that are being written asynchronously are waited for, before and after: whoever waits for them takes part in
    the work, and the threads that write them must not be ended. Raises PendingWriteError if one cannot be written. If
    the block sets the number of threads itself, that stays.
    """
    with lock:
        extend()
    try:
        wait_for_writers()
        yield
    finally:
        with lock:
            restore()


def extend() -> None:
    """Begin a block."""
    if extended.own_count is None and dr.thread_count() < COUNT:
        if mi.variant() is not None:
            prepare_embree(mi.variant())
        extended.own_count = dr.thread_count()
        dr.set_thread_count(COUNT)
    extended.blocks += 1


@cache
def prepare_embree(variant: str) -> None:
    """Build an empty scene, so that Embree uses as many threads as the pool has now.

    Mitsuba sets Embree's number of threads once, to the size of the pool when the first scene is built. Embree has room
    for two threads for each core that the process may run on: four on one core crash the process one time in ten.
    """
    mi.load_dict({"type": "scene"})


def restore() -> None:
    """End a block, and with the last one what was changed of the pool."""
    extended.blocks -= 1
    if extended.blocks or extended.own_count is None:
        return
    if dr.thread_count() == COUNT:
        wait_for_writers()  # if one fails, others may still be at work: the next block ends the threads
        dr.sync_thread()  # kernels are cut up for the number of threads
        dr.set_thread_count(extended.own_count)
    extended.own_count = None


def wait_for_writers() -> None:
    """Take part in writing what is being written asynchronously, until it is done. Raises PendingWriteError."""
    try:
        mi.Thread.wait_for_tasks()
    except RuntimeError as error:
        said = " ".join(str(error).split()).rstrip(".!")
        raise PendingWriteError(f"A file that Mitsuba was writing asynchronously cannot be written: {said}.") from None
