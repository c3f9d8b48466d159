"""The sums of consecutive pixels: arrays on the device of a worker, or one buffer while they travel."""

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
"""Bytes of all sums, array after array."""
TRASH: deque[Any] = deque()
"""Device arrays that are not needed any more. A thread that frees them waits for the device, so only the thread of the
device does it."""


class Sums:
    """Sums that a unit leaves to the next one: as arrays for the worker that made them, as a buffer for others."""

    def __init__(self, strip: Estimate | None, buffer: Buffer | None = None) -> None:
        """``strip``: evaluated estimate with the sums; or None, and the sums are in ``buffer``.

        The arrays are read now: if another thread read them later, to send them, it would have to wait for what the
        device draws at that time.
        """
        self.strip, self.buffer = strip, buffer
        self.arrays = strip.state()[1:] if strip is not None else []

    def packed(self) -> Buffer:
        """Return the sums as one buffer."""
        return pack(self.arrays) if self.buffer is None else self.buffer

    def __del__(self) -> None:
        if self.strip is not None:
            TRASH.append((self.strip, self.arrays))

    def fill(self, strip: Estimate, skip: int) -> None:
        """Give ``strip`` the sums of its pixels, before which there are ``skip`` other pixels in these sums."""
        if self.strip is not None and skip == 0 and self.strip.view.pixel_count == strip.view.pixel_count:
            for band, source_band in zip(strip.bands, self.strip.bands, strict=True):
                band.sums = source_band.sums  # shared, as adding samples makes new arrays
            return
        layout, *alike = strip.blank()
        strip.restore([layout, *cut(self.packed(), alike, skip, strip.view.pixel_count)])

    def __reduce__(self) -> tuple[Any, ...]:
        return Sums, (None, self.packed())


@sizeof.register(Sums)
def bytes_of(sums: Sums) -> int:
    """Return the bytes that sums take. Dask considers them when it chooses a worker for a task that needs the sums."""
    return sum(array.nbytes for array in sums.arrays) if sums.buffer is None else sums.buffer.nbytes


def pack(arrays: Sequence[NDArray]) -> Buffer:
    """Return arrays, (P,) or (P, K), as one buffer."""
    return np.concatenate([array.reshape(-1).view(np.uint8) for array in arrays])


def packed(arrays: Sequence[NDArray], first: int, size: int) -> Buffer:
    """Return as one buffer the sums of ``size`` pixels from ``first`` on, from arrays (P, ...) of the whole picture."""
    return pack([array[first : first + size] for array in arrays])


def cut(sums: Buffer, alike: Sequence[NDArray], skip: int, size: int) -> list[NDArray]:
    """Return the arrays (size, ...) of the ``size`` pixels after the first ``skip`` in a buffer.

    ``alike``: arrays of the same types and shapes, but for their numbers of pixels.
    """
    pixel_bytes = [array[:1].nbytes for array in alike]
    pixel_count = len(sums) // sum(pixel_bytes)
    arrays, start = [], 0
    for array, bytes_each in zip(alike, pixel_bytes, strict=True):
        piece = sums[start + skip * bytes_each : start + (skip + size) * bytes_each]
        arrays.append(piece.view(array.dtype).reshape(size, *array.shape[1:]))
        start += pixel_count * bytes_each
    return arrays


def write(sums: Buffer, region: Region, arrays: Sequence[NDArray]) -> None:
    """Write the sums of a region to their places in arrays (P, ...) of the whole picture."""
    pieces = cut(sums, arrays, region.skip, region.size)
    for array, piece in zip(arrays, pieces, strict=True):
        array[region.pixels] = piece


def by_source(regions: Sequence[Region]) -> list[list[Region]]:
    """Return the regions that have sums, in groups whose sums have one source."""
    groups: dict[int, list[Region]] = {}
    for region in regions:
        if region.source is not None:
            groups.setdefault(id(region.source), []).append(region)
    return list(groups.values())
