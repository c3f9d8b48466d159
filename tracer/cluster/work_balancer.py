"""Cut a picture into regions, a round into units of about the same time, and deal them out to workers."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

UNITS_PER_WORKER = 5
"""Of a round, about: so that those that are done early find more to do."""
FIRST_SAMPLES = 1 << 18
"""Least samples of a unit before it is known how long they take."""
TYPICAL_PACE = 1e-6
"""Seconds a sample, as long as nothing is known."""
LEAST_SECONDS, MOST_SECONDS = 0.4, 1.5
"""Of a unit: whatever else it takes, by all who have to do with it, is 0.02. More"""
SCHEDULER_SECONDS = 4e-3
"""for each worker, where they are many: so long the scheduler is busy with a unit."""
MOVE_SECONDS = 5e-6
"""A pixel, to bring its sums to another worker, for either of them."""
LEAST_GAIN = 0.1
"""Share of a unit's time by which a round must become shorter for it to be moved."""


@dataclass(frozen=True)
class Region:
    """Consecutive pixels whose sums are in one place."""

    first: int
    size: int
    source: Any = None
    """Future of what a unit has returned, for these pixels and perhaps others; None: they have no samples."""
    skip: int = 0
    """Pixels before these in what it has returned."""
    pace: float | None = None
    """Seconds a sample, when some were last drawn."""
    worker: str | None = None
    """Who has the sums."""

    @property
    def pixels(self) -> slice:
        """Where its pixels are in arrays of the whole picture."""
        return slice(self.first, self.first + self.size)

    def part(self, begin: int, end: int) -> Region:
        """Return the pixels from ``begin`` up to ``end``, counted from the first one, with their place in the sums."""
        return replace(self, first=self.first + begin, size=end - begin, skip=self.skip + begin)


def expected_seconds(sample_counts: Sequence[int], paces: Sequence[float | None]) -> list[float]:
    """Return how long so many samples should take at their paces (seconds a sample), the mean where none is known."""
    known = [pace for pace in paces if pace is not None]
    typical = sum(known) / len(known) if known else TYPICAL_PACE
    return [count * (typical if pace is None else pace) for count, pace in zip(sample_counts, paces, strict=True)]


def seconds_of(regions: Sequence[Region], counts: NDArray[np.uint32]) -> list[float]:
    """Return how long each region is expected to take for its ``counts`` (P,), even if none has been drawn yet."""
    return expected_seconds([samples_of(region, counts) for region in regions], [region.pace for region in regions])


def samples_of(region: Region, counts: NDArray[np.uint32]) -> int:
    """Return the samples of a region."""
    return int(counts[region.pixels].sum(dtype=np.int64))


def divide(regions: Sequence[Region], counts: NDArray[np.uint32], workers: int) -> list[Region]:
    """Return the regions, those cut in parts that would take too long for their ``counts`` (P,) as one unit."""
    seconds = seconds_of(regions, counts)
    if all(region.pace is None for region in regions):
        total = int(counts.sum(dtype=np.int64))
        most = max(ceil(total / (UNITS_PER_WORKER * workers)), FIRST_SAMPLES)
        even = ceil(total / most / workers) * workers
        parts = [ceil(even * samples_of(region, counts) / max(total, 1)) for region in regions]
    else:
        wanted = sum(seconds) / (UNITS_PER_WORKER * workers)
        feed = SCHEDULER_SECONDS * workers
        limit = max(min(wanted, MOST_SECONDS), LEAST_SECONDS, feed)
        parts = [ceil(each / limit) for each in seconds]
    return [part for region, number in zip(regions, parts, strict=True) for part in split(region, counts, number)]


def split(region: Region, counts: NDArray[np.uint32], parts: int) -> list[Region]:
    """Return a region in so many parts with about equally many of the ``counts`` of the picture, or fewer."""
    return split_at(region, counts[region.pixels], [k / parts for k in range(1, parts)])


def split_at(region: Region, counts: NDArray[np.uint32], shares: Sequence[float]) -> list[Region]:
    """Return a region cut where these shares of its ``counts`` (P,) are reached; no pixel is cut, and none is empty."""
    ends = np.cumsum(counts, dtype=np.int64)
    wanted = np.floor(ends[-1] * np.asarray(shares))
    borders = np.unique([0, *np.minimum(np.searchsorted(ends, wanted, side="left") + 1, region.size), region.size])
    return [region.part(int(begin), int(end)) for begin, end in itertools.pairwise(borders)]


def deal(regions: Sequence[Region], seconds: Sequence[float], workers: Sequence[str]) -> list[str]:
    """Return who is to draw each region: who has its sums, but for those whose move makes the round shorter.

    What nobody has is given, the longest first, to who is done with it first (R. Graham, 1969). Then who is done last
    hands over to who is done first, as long as that helps.
    """
    done = dict.fromkeys(workers, 0.0)
    own: dict[str, list[int]] = {worker: [] for worker in workers}
    homeless = [k for k, region in enumerate(regions) if region.worker not in done]
    for k, region in enumerate(regions):
        if region.worker in done:
            done[region.worker] += seconds[k]
            own[region.worker].append(k)
    for k in sorted(homeless, key=lambda k: -seconds[k]):
        best = min(done, key=lambda worker: done[worker])
        done[best] += seconds[k]
        own[best].append(k)
    for _ in regions:
        last, first = max(done, key=lambda worker: done[worker]), min(done, key=lambda worker: done[worker])
        # Both are busy with a move.
        moves = {k: MOVE_SECONDS * regions[k].size * (regions[k].source is not None) for k in own[last]}
        ends = {k: max(done[last] - seconds[k], done[first] + seconds[k]) + moves[k] for k in own[last]}
        k = min(ends, key=lambda k: ends[k], default=-1)
        if k < 0 or ends[k] > done[last] - LEAST_GAIN * seconds[k]:
            break
        done[last] += moves[k] - seconds[k]
        done[first] += moves[k] + seconds[k]
        own[last].remove(k)
        own[first].append(k)
    chosen = {k: worker for worker, several in own.items() for k in several}
    return [chosen[k] for k in range(len(regions))]
