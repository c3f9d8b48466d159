"""Work on large NumPy arrays by as many threads as Dr.Jit has.

One thread copies about 3 GB a second, and less to memory that is new: where all cores draw samples, what one of them
does alone between two rounds soon takes longer than drawing. NumPy lets go of Python's lock while it works on an array.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import drjit as dr
from numpy.typing import NDArray

LEAST_ENTRIES = 1 << 18
"""Number of entries from which on an array is divided among threads."""
MOST_THREADS = 16
"""More of them do not copy any faster."""


@cache
def executor(thread_count: int) -> ThreadPoolExecutor:
    """Return threads that wait for work."""
    return ThreadPoolExecutor(thread_count, thread_name_prefix="tracer-arrays")


def fill(target: NDArray, function: Callable[..., Any], *sources: NDArray) -> NDArray:
    """Set ``target[k]`` to ``function(source[k], ...)`` for slices k of the first axis, and return ``target``.

    ``function`` must treat every entry of that axis by itself, as NumPy's element-wise functions do.
    """
    thread_count = min(dr.thread_count(), MOST_THREADS)
    if target.size < LEAST_ENTRIES or thread_count < 2:
        target[...] = function(*sources)
        return target
    # A thread of the pool may keep what it was given for a moment. It must not be the last to hold memory of Dr.Jit:
    # it would wait for Dr.Jit's lock while it holds Python's. So it is only given this list, which is emptied.
    held = [target, *sources]

    def work(part: int) -> None:
        rows = slice(len(held[0]) * part // thread_count, len(held[0]) * (part + 1) // thread_count)
        held[0][rows] = function(*(source[rows] for source in held[1:]))

    try:
        list(executor(thread_count).map(work, range(thread_count)))
    finally:
        held.clear()
    return target


def copy(target: NDArray, source: NDArray) -> NDArray:
    """Copy ``source`` into ``target`` of the same shape, cast to its type, and return ``target``."""
    return fill(target, lambda rows: rows, source)
