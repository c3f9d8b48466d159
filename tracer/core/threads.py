"""Keep enough threads in Dr.Jit's pool wherever Mitsuba may read or write an EXR file.

Mitsuba hands the blocks of an EXR file to the workers of the pool and waits until they are done, without helping. The
waiting thread counts as one of the pool: in a pool of one thread there is no worker, and Mitsuba waits for ever. A
file that is written asynchronously, as ``mi.util.write_bitmap`` does by default, occupies a worker that waits in the
same way. So a pool needs one thread more than there are EXR files under way, and another one to read the next file.
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
"""Least threads in the pool within ``for_files``: enough to read or write one file while two others, which somebody
else has begun, are being written. To start and end the threads takes 0.1 to 0.4 ms."""


@dataclass
class Extended:
    """The pool while any block of ``for_files`` is open, in whatever thread."""

    blocks: int = 0
    """Number of blocks of ``for_files`` that are open."""
    own_count: int | None = None
    """Threads that the pool had before it was extended; None while it is as somebody else has set it."""


extended = Extended()
lock = threading.Lock()


@contextmanager
def for_files() -> Iterator[None]:
    """Keep at least COUNT threads in the pool within the block; after it, the pool has as many as before.

    Waits before and after the block for files that are being written asynchronously: the waiting thread takes part in
    the work, and the threads that write them must not be ended. Raises PendingWriteError if a file cannot be written.
    If the block sets the number of threads itself, the pool keeps that number.
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
    """Begin a block of ``for_files``, and extend the pool if it has fewer than COUNT threads."""
    if extended.own_count is None and dr.thread_count() < COUNT:
        if mi.variant() is not None:
            prepare_embree(mi.variant())
        extended.own_count = dr.thread_count()
        dr.set_thread_count(COUNT)
    extended.blocks += 1


@cache
def prepare_embree(variant: str) -> None:
    """Build an empty scene, so that Embree uses as many threads as the pool has now.

    Mitsuba sets Embree's number of threads once, to the size that the pool has when the first scene is built. Embree
    has room for two threads per core that the process may run on: four threads on one core crash the process one time
    in ten.
    """
    mi.load_dict({"type": "scene"})


def restore() -> None:
    """End a block of ``for_files``, and with the last block restore the size of the pool."""
    extended.blocks -= 1
    if extended.blocks or extended.own_count is None:
        return
    if dr.thread_count() == COUNT:
        wait_for_writers()  # if one file fails, others may still be under way: the next block ends the threads
        dr.sync_thread()  # kernels under way are divided among the present threads
        dr.set_thread_count(extended.own_count)
    extended.own_count = None


def wait_for_writers() -> None:
    """Take part in writing the files that are being written asynchronously, until all are. Raises PendingWriteError."""
    try:
        mi.Thread.wait_for_tasks()
    except RuntimeError as error:
        reason = " ".join(str(error).split()).rstrip(".!")
        raise PendingWriteError(
            f"A file that Mitsuba was writing asynchronously cannot be written: {reason}."
        ) from None
