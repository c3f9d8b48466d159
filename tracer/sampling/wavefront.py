"""The samples of a round, laid out pixel after pixel, and cut into parts and passes that trace whole packets of rays.

The list of samples is never stored. A pass is a window of the line, and each lane finds its pixel by a running sum over
the marks where pixels begin.

Where a ray meets two surfaces at once, it depends on the other rays of its packet which one Embree finds. So that the
picture does not depend on how a round is cut, packets are those of the whole round: whoever draws a part of it traces
the few samples before and after, too, that share a packet with its own, and does not add them.
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
"""Lanes whose rays Embree traces together, or a multiple: 4, 8 or 16, by what the processor has."""


@dataclass(frozen=True)
class Window:
    """The part of a line that one pass traces: lanes ``begin[k]`` to ``end[k]`` belong to ``first_pixel + k``."""

    first_pixel: int
    """Counted from the first one of the estimate; the window may begin before it and end after its last one."""
    lane_count: int
    begin: Counts
    """(pixels of the window,): first lane of each pixel."""
    own: Counts
    """(pixels of the window,): the first that is added."""
    end: Counts
    """(pixels of the window,): one past the last lane of each pixel."""
    base: Counts
    """(pixels of the window,): sample index minus lane (modulo 2^32)."""

    @property
    def sample_count(self) -> int:
        """Samples that are added."""
        return int((self.end - self.own).sum(dtype=np.int64))

    def touches(self, first: int, size: int) -> bool:
        """Say whether any of ``size`` pixels from ``first`` may have lanes."""
        return self.first_pixel < first + size and first < self.first_pixel + len(self.begin)

    def lanes_of(self, first: int, size: int) -> tuple[Any, Any]:
        """Return (begin, end) of what is added to ``size`` pixels from ``first``, mi.UInt32; to others nothing is."""
        low, high = max(first, self.first_pixel), min(first + size, self.first_pixel + len(self.begin))
        found = []
        for lanes in (self.own, self.end):
            whole = np.zeros(size, np.uint32)
            whole[low - first : high - first] = lanes[low - self.first_pixel : high - self.first_pixel]
            found.append(upload(mi.UInt32, whole))
        return found[0], found[1]


@dataclass(frozen=True)
class Stretch:
    """Samples ``before`` to ``after`` - 1 of consecutive pixels in a round; the first one is the first of a packet."""

    first_pixel: int
    before: Counts
    """(P,): samples of each pixel before the round."""
    after: Counts
    """(P,): the same after it."""

    @cached_property
    def ends(self) -> NDArray[np.int64]:
        """(P,): one past the last lane of each pixel."""
        return np.cumsum(self.after - self.before, dtype=np.int64)

    @property
    def nbytes(self) -> int:
        """Bytes of its arrays."""
        return self.before.nbytes + self.after.nbytes

    def part(self, first: int, size: int) -> Stretch:
        """Return the packets that have samples of ``size`` pixels from ``first``, with their neighbours' samples."""
        first -= self.first_pixel
        ends = self.ends
        start = floor(ends[first - 1] if first else 0)
        stop = min(ceil(ends[first + size - 1]), int(ends[-1]))
        low = min(int(np.searchsorted(ends, start, side="right")), first)
        high = max(int(np.searchsorted(ends, stop, side="left")) + 1, first + size)
        before, after = self.before[low:high].copy(), self.after[low:high].copy()
        before[0] += max(start - int(ends[low - 1] if low else 0), 0)
        after[-1] -= max(int(ends[high - 1]) - stop, 0)
        return Stretch(self.first_pixel + low, before, after)


class Line:
    """What is still to be drawn of a stretch, in whole packets, cut into passes one after the other."""

    def __init__(self, stretch: Stretch, drawn: Counts | None = None, first_pixel: int = 0) -> None:
        """``drawn`` (P,): samples of each pixel that there are, ``before`` to ``after`` of the stretch; None: before.

        ``first_pixel``: of the estimate that they are added to.
        """
        ends = stretch.ends
        begins = ends - (stretch.after - stretch.before)
        drawn = stretch.before if drawn is None else drawn
        self.first_pixel = stretch.first_pixel - first_pixel
        own = begins + (drawn - stretch.before)
        low, high = whole_packets(begins, own, ends)
        self.ends = np.cumsum(high - low)
        self.begins = self.ends - (high - low)
        self.own = np.minimum(self.begins + (own - low), self.ends)
        self.base = stretch.before + (low - begins) - self.begins
        self.total = int(self.ends[-1]) if len(ends) else 0
        """Lanes."""
        self.taken = 0

    def take(self, size: int) -> Window:
        """Return the next ``size`` lanes, or what is left; a pixel may be split between passes, and no packet is."""
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
        """Yield the rest in passes of one size."""
        while self.taken < self.total:
            yield self.take(size)


def line_of(counts: Counts) -> Line:
    """Return a line of the first ``counts`` (P,) samples of all pixels of a picture."""
    return Line(Stretch(0, np.zeros_like(counts), counts))


def whole_packets(
    begins: NDArray[np.int64], own: NDArray[np.int64], ends: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return (first lane, one past the last) of each pixel to trace so that all of lanes ``own`` to ``ends`` are.

    All (P,). Pixels have the lanes from ``begins``; those between two that are needed are traced, too.
    """
    if np.array_equal(begins, own):
        return begins, ends
    needed = own < ends
    reach_down = np.where(needed, floor(own), ends[-1] + PACKET)
    reach_up = np.where(needed, ceil(ends), 0)
    # How far packets of needed samples reach into a pixel from those after it, itself included, and before it.
    from_after = np.minimum.accumulate(reach_down[::-1])[::-1]
    from_before = np.concatenate([[0], np.maximum.accumulate(reach_up)[:-1]])
    low = np.where(from_before > begins, begins, np.clip(from_after, begins, ends))
    high = np.where(from_after < ends, ends, np.clip(from_before, begins, ends))
    return low, np.maximum(low, high)


def floor(lane: Any) -> Any:
    """Return the first lane of a packet."""
    return lane // PACKET * PACKET


def ceil(lane: Any) -> Any:
    """Return the first lane of the next packet, or ``lane`` if that is the first of one."""
    return floor(lane + PACKET - 1)


def lane_pixels(window: Window, first_pixel: int = 0) -> tuple[Any, Any]:
    """Return (pixel, sample index) of every lane of a window, as mi.UInt32.

    ``first_pixel``: that of the estimate, in the picture.
    """
    marks = dr.zeros(mi.UInt32, window.lane_count)
    # Left to itself Dr.Jit chooses the mode by the size of ``marks``, and compiles one kernel for each.
    dr.scatter_add(marks, mi.UInt32(1), upload(mi.UInt32, window.begin), mode=dr.ReduceMode.Direct)
    rank = dr.cumsum(marks) - 1
    index = dr.gather(mi.UInt32, upload(mi.UInt32, window.base), rank) + dr.arange(mi.UInt32, window.lane_count)
    return rank + dr.opaque(mi.UInt32, first_pixel + window.first_pixel), index
