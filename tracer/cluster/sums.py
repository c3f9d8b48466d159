"""Sums on their way: many arrays of one number a pixel, in one piece, from and to workers."""

from __future__ import annotations

import queue
import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.cluster.regions import Region

Buffer = NDArray[np.uint8]
"""The sums of consecutive pixels, array after array."""
Inbox = queue.SimpleQueue[tuple[Any, Any]]


def pack(arrays: Sequence[NDArray]) -> Buffer:
    """Return arrays (P,) in one piece."""
    return np.concatenate([each.view(np.uint8) for each in arrays])


def cut(sums: Buffer, kinds: Sequence[np.dtype], skip: int, size: int) -> list[NDArray]:
    """Return the arrays, of these ``kinds``, that a buffer holds, for ``size`` pixels from the one after ``skip``."""
    pixels = len(sums) // sum(kind.itemsize for kind in kinds)
    found, at = [], 0
    for kind in kinds:
        piece = sums[at + skip * kind.itemsize : at + (skip + size) * kind.itemsize]
        found.append(piece.view(kind))
        at += pixels * kind.itemsize
    return found


def write(sums: Buffer, region: Region, arrays: Sequence[NDArray]) -> None:
    """Write the sums of a region to their places in arrays (P,) of the whole picture."""
    pieces = cut(sums, [each.dtype for each in arrays], region.skip, region.size)
    for array, piece in zip(arrays, pieces, strict=True):
        array[region.first : region.first + region.size] = piece


def by_source(regions: Sequence[Region]) -> list[list[Region]]:
    """Return the regions that have sums, together those whose sums are in one piece."""
    found: dict[int, list[Region]] = {}
    for region in regions:
        if region.source is not None:
            found.setdefault(id(region.source), []).append(region)
    return list(found.values())


def fetch(future: Any, label: Any, inbox: Inbox) -> None:
    """Put label and result of a future, or what went wrong, into ``inbox`` once it is there.

    In a thread of its own, as the worker that has it may hang.
    """

    def get() -> None:
        try:
            inbox.put((label, future.result()))
        except BaseException as error:
            inbox.put((label, error))

    threading.Thread(target=get, daemon=True).start()
