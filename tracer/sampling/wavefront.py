"""The samples of a round in a line, pixel after pixel, cut into parts and passes that trace whole packets of rays.

The list of samples is never stored. A pass is a window of the line, and each lane finds its pixel by a running sum over
marks at the lanes where pixels begin.

Where a ray meets two surfaces at once, the other rays of its packet decide which one Embree finds. So that the picture
does not depend on how a round is cut, packets are always those of the whole round: a worker that draws a part of the
round also traces the few samples before and after it that share a packet with its own, and does not add them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Counts
from tracer.core.device import upload

PACKET = 16
"""Lanes of a packet. Embree traces the rays of 4, 8 or 16 lanes together, depending on the processor; 16 is a multiple
of each, and so are the lanes that a kernel runs together."""


@dataclass(frozen=True)
class Window:
    """Part of a line that a pass traces. Lanes ``begin[k]`` to ``end[k]`` - 1 belong to pixel ``first_pixel`` + k."""

    first_pixel: int
    """Counted from the first pixel of the estimate. The window may begin before it, and end after the last pixel."""
    lane_count: int
    """Number of lanes of the window."""
    begin: Counts
    """(pixels of the window,): first lane of each pixel."""
    own: Counts
    """(pixels of the window,): first lane of each pixel that is added."""
    end: Counts
    """(pixels of the window,): one past the last lane of each pixel."""
    base: Counts
    """(pixels of the window,): sample index minus lane (modulo 2^32)."""

    @property
    def sample_count(self) -> int:
        """Number of samples that are added."""
        return int((self.end - self.own).sum(dtype=np.int64))

    def touches(self, first_pixel: int, size: int) -> bool:
        """Return whether any of ``size`` pixels from ``first_pixel`` on may have lanes."""
        return self.first_pixel < first_pixel + size and first_pixel < self.first_pixel + len(self.begin)

    def lanes_of(self, first_pixel: int, size: int) -> tuple[mi.UInt32, mi.UInt32]:
        """Return (begin, end) of the lanes added to each of ``size`` pixels from ``first_pixel`` on."""
        low, high = max(first_pixel, self.first_pixel), min(first_pixel + size, self.first_pixel + len(self.begin))
        bounds = []
        for lanes in (self.own, self.end):
            padded = np.zeros(size, np.uint32)
            padded[low - first_pixel : high - first_pixel] = lanes[low - self.first_pixel : high - self.first_pixel]
            bounds.append(upload(mi.UInt32, padded))
        return bounds[0], bounds[1]


@dataclass(frozen=True)
class Stretch:
    """Samples ``before`` to ``after`` - 1 of consecutive pixels in a round. The first of them begins a packet."""

    first_pixel: int
    """Number of the first pixel in the picture."""
    before: Counts
    """(P,): samples of each pixel before the round."""
    after: Counts
    """(P,): samples of each pixel after the round."""

    @cached_property
    def ends(self) -> NDArray[np.int64]:
        """(P,): one past the last lane of each pixel."""
        return np.cumsum(self.after - self.before, dtype=np.int64)

    @property
    def nbytes(self) -> int:
        """Size of its arrays in bytes."""
        return self.before.nbytes + self.after.nbytes

    def part(self, first_pixel: int, size: int) -> Stretch:
        """Return all packets with samples of ``size`` pixels from ``first_pixel`` on, with all samples in them."""
        first_pixel -= self.first_pixel
        ends = self.ends
        start = floor(ends[first_pixel - 1] if first_pixel else 0)
        stop = min(ceil(ends[first_pixel + size - 1]), int(ends[-1]))
        low = min(int(np.searchsorted(ends, start, side="right")), first_pixel)
        high = max(int(np.searchsorted(ends, stop, side="left")) + 1, first_pixel + size)
        before, after = self.before[low:high].copy(), self.after[low:high].copy()
        before[0] += max(start - int(ends[low - 1] if low else 0), 0)
        after[-1] -= max(int(ends[high - 1]) - stop, 0)
        return Stretch(self.first_pixel + low, before, after)


class Line:
    """The samples of a stretch that are still to be drawn, in whole packets, from which passes are taken one by one."""

    def __init__(self, stretch: Stretch, drawn: Counts | None = None, first_pixel: int = 0) -> None:
        """``drawn`` (P,): samples that each pixel has, from ``before`` to ``after`` of the stretch; None: ``before``.

        ``first_pixel``: first pixel of the estimate to which they are added.
        """
        self.first_pixel = stretch.first_pixel - first_pixel
        self.ends = stretch.ends
        self.begins: NDArray[np.int64] = self.ends - (stretch.after - stretch.before)
        self.own = self.begins
        self.base: NDArray[np.int64] = stretch.before - self.begins
        if drawn is not None and not np.array_equal(drawn, stretch.before):
            self.leave_out(drawn - stretch.before)
        self.total = int(self.ends[-1]) if len(self.ends) else 0
        """Number of lanes."""
        self.taken = 0

    def leave_out(self, not_needed: Counts) -> None:
        """Leave out packets of which no sample is needed; ``not_needed`` (P,): of each pixel, how many of the first."""
        begins, ends = self.begins, self.ends
        first_needed: NDArray[np.int64] = begins + not_needed
        low, high = whole_packets(begins, first_needed, ends)
        self.ends = np.cumsum(high - low)
        self.begins = self.ends - (high - low)
        self.own = np.minimum(self.begins + (first_needed - low), self.ends)
        self.base = self.base + low - self.begins

    def take(self, size: int) -> Window:
        """Return the next ``size`` lanes, or those that are left. Passes may split a pixel, but never a packet."""
        start, stop = self.taken, min(self.taken + ceil(size), self.total)
        self.taken = stop
        low = int(np.searchsorted(self.ends, start, side="right"))
        high = int(np.searchsorted(self.begins, stop, side="left"))
        pixels = slice(low, high)
        end = np.minimum(self.ends[pixels] - start, stop - start)
        return Window(
            first_pixel=self.first_pixel + low,
            lane_count=stop - start,
            begin=np.maximum(self.begins[pixels] - start, 0).astype(np.uint32),
            own=np.clip(self.own[pixels] - start, 0, end).astype(np.uint32),
            end=end.astype(np.uint32),
            base=((self.base[pixels] + start) & 0xFFFFFFFF).astype(np.uint32),
        )

    def passes(self, size: int) -> Iterator[Window]:
        """Yield the rest in passes of ``size`` lanes."""
        while self.taken < self.total:
            yield self.take(size)


def line_of(counts: Counts) -> Line:
    """Return a line with the first ``counts`` (P,) samples of all pixels of a picture."""
    return Line(Stretch(0, np.zeros_like(counts), counts))


def whole_packets(
    begins: NDArray[np.int64], first_needed: NDArray[np.int64], ends: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return (first lane, one past the last) of each pixel to trace, so that whole packets hold the needed lanes.

    All arrays are (P,). Each pixel has the lanes ``begins`` to ``ends`` - 1 and needs those from ``first_needed`` on.
    Lanes between two needed ones of a packet are traced, too.
    """
    needed = first_needed < ends
    reach_down = np.where(needed, floor(first_needed), ends[-1] + PACKET)
    reach_up = np.where(needed, ceil(ends), 0)
    # How far packets of needed samples reach into a pixel: of the pixel itself and those after it, and of those before.
    from_after = np.minimum.accumulate(reach_down[::-1])[::-1]
    from_before = np.concatenate([[0], np.maximum.accumulate(reach_up)[:-1]])
    low = np.where(from_before > begins, begins, np.clip(from_after, begins, ends))
    high = np.where(from_after < ends, ends, np.clip(from_before, begins, ends))
    return low, np.maximum(low, high)


def floor(lane: Any) -> Any:
    """Return the first lane of the packet that ``lane`` is in."""
    return lane // PACKET * PACKET


def ceil(lane: Any) -> Any:
    """Return ``lane`` if it is the first of a packet, else the first lane of the next packet."""
    return floor(lane + PACKET - 1)


def lane_pixels(window: Window, first_pixel: int = 0) -> tuple[mi.UInt32, mi.UInt32]:
    """Return (pixel, sample index) of every lane of a window.

    ``first_pixel``: number in the picture of the first pixel of the estimate.
    """
    marks = dr.zeros(mi.UInt32, window.lane_count)
    # By default Dr.Jit chooses the mode by the size of ``marks``, and compiles a kernel for each mode.
    dr.scatter_add(marks, mi.UInt32(1), upload(mi.UInt32, window.begin), mode=dr.ReduceMode.Direct)
    rank = dr.cumsum(marks) - 1
    index = dr.gather(mi.UInt32, upload(mi.UInt32, window.base), rank) + dr.arange(mi.UInt32, window.lane_count)
    return rank + dr.opaque(mi.UInt32, first_pixel + window.first_pixel), index
