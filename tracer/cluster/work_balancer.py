"""Cut a picture into regions that take about the same time to draw, and deal them out to workers."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

UNITS_PER_WORKER = 5
"""Number of units of a round for each worker, about: enough for workers that are done early to find more to do."""
FIRST_SAMPLES = 1 << 18
"""Least samples of a unit before it is known how long samples take."""
TYPICAL_PACE = 1e-6
"""Seconds per sample that are assumed as long as nothing is known."""
LEAST_SECONDS, MOST_SECONDS = 0.4, 1.5
"""Least and most seconds of a unit. All else that client, scheduler and worker do for a unit takes 0.02 seconds."""
SCHEDULER_SECONDS = 4e-3
"""Seconds that the scheduler is busy with a unit. If workers are many, a unit takes at least this long times their
number, so that the scheduler keeps up with them."""
MOVE_SECONDS = 5e-6
"""Seconds per pixel that it takes either worker to move sums from one worker to another."""
LEAST_GAIN = 0.1
"""Share of a unit's time by which a round must become shorter for the unit to be moved."""


@dataclass(frozen=True)
class Region:
    """Consecutive pixels whose sums are in one place."""

    first: int
    """Number of the first pixel in the picture."""
    size: int
    """Number of pixels."""
    source: Any = None
    """Future of the sums of these pixels and perhaps others, as a unit returned them; None: there are no samples."""
    skip: int = 0
    """Number of pixels before these in the sums of ``source``."""
    pace: float | None = None
    """Seconds per sample when samples of the region were last drawn; None if that is not known."""
    worker: str | None = None
    """Address of the worker that has the sums; None if that is not known."""

    @property
    def pixels(self) -> slice:
        """Slice of the region in arrays (P,) of the whole picture."""
        return slice(self.first, self.first + self.size)

    def part(self, begin: int, end: int) -> Region:
        """Return the pixels ``begin`` to ``end`` - 1 of the region, with their place in the sums."""
        return replace(self, first=self.first + begin, size=end - begin, skip=self.skip + begin)


def expected_seconds(sample_counts: Sequence[int], paces: Sequence[float | None]) -> list[float]:
    """Return the seconds that each number of samples should take at its pace, in seconds per sample.

    Where a pace is None, the mean of the paces that are known takes its place.
    """
    known = [pace for pace in paces if pace is not None]
    typical = sum(known) / len(known) if known else TYPICAL_PACE
    return [count * (typical if pace is None else pace) for count, pace in zip(sample_counts, paces, strict=True)]


def seconds_of(regions: Sequence[Region], counts: NDArray[np.uint32]) -> list[float]:
    """Return the seconds that each region is expected to take; ``counts`` (P,): samples to draw in the picture."""
    return expected_seconds([samples_of(region, counts) for region in regions], [region.pace for region in regions])


def samples_of(region: Region, counts: NDArray[np.uint32]) -> int:
    """Return the number of samples of a region, of the ``counts`` (P,) of the whole picture."""
    return int(counts[region.pixels].sum(dtype=np.int64))


def divide(regions: Sequence[Region], counts: NDArray[np.uint32], workers: int) -> list[Region]:
    """Return the regions, those in parts that would take too long as one unit.

    ``counts`` (P,): samples to draw in the whole picture; ``workers``: number of workers.
    """
    seconds = seconds_of(regions, counts)
    if all(region.pace is None for region in regions):
        total = int(counts.sum(dtype=np.int64))
        most = max(ceil(total / (UNITS_PER_WORKER * workers)), FIRST_SAMPLES)
        even = ceil(total / most / workers) * workers
        parts = [ceil(even * samples_of(region, counts) / max(total, 1)) for region in regions]
    else:
        even_seconds = sum(seconds) / (UNITS_PER_WORKER * workers)
        scheduler_limit = SCHEDULER_SECONDS * workers
        limit = max(min(even_seconds, MOST_SECONDS), LEAST_SECONDS, scheduler_limit)
        parts = [ceil(region_seconds / limit) for region_seconds in seconds]
    return [part for region, number in zip(regions, parts, strict=True) for part in split(region, counts, number)]


def split(region: Region, counts: NDArray[np.uint32], parts: int) -> list[Region]:
    """Return a region in at most ``parts`` parts with about equally many of the ``counts`` (P,) of the picture."""
    return split_at(region, counts[region.pixels], [k / parts for k in range(1, parts)])


def split_at(region: Region, counts: NDArray[np.uint32], shares: Sequence[float]) -> list[Region]:
    """Return a region cut where these shares of its ``counts`` (P,) are reached; pixels are whole, no part is empty."""
    ends = np.cumsum(counts, dtype=np.int64)
    targets = np.floor(ends[-1] * np.asarray(shares))
    borders = np.unique([0, *np.minimum(np.searchsorted(ends, targets, side="left") + 1, region.size), region.size])
    return [region.part(int(begin), int(end)) for begin, end in itertools.pairwise(borders)]


def deal(regions: Sequence[Region], seconds: Sequence[float], workers: Sequence[str]) -> list[str]:
    """Return the worker that is to draw each region; ``seconds``: time that each region is expected to take.

    A region goes to the worker that has its sums. Regions whose sums no worker has are given out, the longest first,
    each to the worker that has least to do (R. Graham, 1969). Then the worker that is done last hands over regions to
    the worker that is done first, as long as that makes the round shorter.
    """
    done = dict.fromkeys(workers, 0.0)
    numbers: dict[str, list[int]] = {worker: [] for worker in workers}
    homeless = [k for k, region in enumerate(regions) if region.worker not in done]
    for k, region in enumerate(regions):
        if region.worker in done:
            done[region.worker] += seconds[k]
            numbers[region.worker].append(k)
    for k in sorted(homeless, key=lambda k: -seconds[k]):
        best = min(done, key=lambda worker: done[worker])
        done[best] += seconds[k]
        numbers[best].append(k)
    for _ in regions:
        last, first = max(done, key=lambda worker: done[worker]), min(done, key=lambda worker: done[worker])
        # A move takes time from both workers.
        moves = {k: MOVE_SECONDS * regions[k].size * (regions[k].source is not None) for k in numbers[last]}
        ends = {k: max(done[last] - seconds[k], done[first] + seconds[k]) + moves[k] for k in numbers[last]}
        k = min(ends, key=lambda k: ends[k], default=-1)
        if k < 0 or ends[k] > done[last] - LEAST_GAIN * seconds[k]:
            break
        done[last] += moves[k] - seconds[k]
        done[first] += moves[k] + seconds[k]
        numbers[last].remove(k)
        numbers[first].append(k)
    chosen = {k: worker for worker, own_numbers in numbers.items() for k in own_numbers}
    return [chosen[k] for k in range(len(regions))]
