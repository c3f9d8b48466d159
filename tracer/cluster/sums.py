"""The sums of consecutive pixels: on the device of a worker, or in one piece on their way."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np
from dask.sizeof import sizeof
from numpy.typing import NDArray

from tracer.cluster.work_balancer import Region
from tracer.film.estimate import Estimate

Buffer = NDArray[np.uint8]
"""Sums, array after array."""
TRASH: deque[Any] = deque()
"""Device arrays that nobody wants any more; whoever frees them waits for the device, so that is left to its thread."""


class Sums:
    """What a unit leaves to the next one: used as it is by the worker that made it, packed for any other process."""

    def __init__(self, strip: Estimate | None, buffer: Buffer | None = None) -> None:
        """``strip`` must be evaluated. Its arrays are asked for now: another thread, that sends them, would have to
        wait for what the device draws meanwhile.
        """
        self.strip, self.buffer = strip, buffer
        self.arrays = strip.state()[1:] if strip is not None else []

    def packed(self) -> Buffer:
        """Return the sums in one piece."""
        return pack(self.arrays) if self.buffer is None else self.buffer

    def __del__(self) -> None:
        if self.strip is not None:
            TRASH.append((self.strip, self.arrays))

    def fill(self, strip: Estimate, skip: int) -> None:
        """Give ``strip`` the sums of its pixels, which come after ``skip`` others."""
        if self.strip is not None and skip == 0 and self.strip.view.pixel_count == strip.view.pixel_count:
            for band, own in zip(strip.bands, self.strip.bands, strict=True):
                band.sums = own.sums  # adding to it makes new ones
            return
        kinds = [each.dtype for each in strip.state()[1:]]
        strip.restore([strip.layout, *cut(self.packed(), kinds, skip, strip.view.pixel_count)])

    def __reduce__(self) -> tuple[Any, ...]:
        return Sums, (None, self.packed())


@sizeof.register(Sums)
def bytes_of(sums: Sums) -> int:
    """Return how much memory sums take, which Dask goes by when it chooses who works with them."""
    return sum(each.nbytes for each in sums.arrays) if sums.buffer is None else sums.buffer.nbytes


def pack(arrays: Sequence[NDArray]) -> Buffer:
    """Return arrays (P,) in one piece."""
    return np.concatenate([each.view(np.uint8) for each in arrays])


def packed(arrays: Sequence[NDArray], first: int, size: int) -> Buffer:
    """Return in one piece the sums of ``size`` pixels from ``first`` in arrays of the whole picture."""
    return pack([each[first : first + size] for each in arrays])


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
        array[region.pixels] = piece


def by_source(regions: Sequence[Region]) -> list[list[Region]]:
    """Return the regions that have sums, together those whose sums are in one piece."""
    found: dict[int, list[Region]] = {}
    for region in regions:
        if region.source is not None:
            found.setdefault(id(region.source), []).append(region)
    return list(found.values())
