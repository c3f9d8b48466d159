"""Cut a picture into regions, and a round into units: consecutive pixels with their samples of that round."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

UNITS_PER_WORKER = 8
"""Of a round, at least: so that those that are done early find more to do."""
LEAST_SAMPLES = 1 << 17
"""Of a unit: a thread draws them in tens of milliseconds, and to send a unit takes a few."""
FIRST_SAMPLES = 1 << 20
"""Most samples of a unit before it is known how fast workers are."""
UNIT_SECONDS = 1.5
"""Afterwards, most seconds."""


@dataclass(frozen=True)
class Region:
    """Consecutive pixels whose sums are in one place."""

    first: int
    size: int
    source: Any = None
    """Future of what a unit has returned, for these pixels and perhaps others; None: they have no samples."""
    skip: int = 0
    """Pixels before these in what it has returned."""


def largest_unit(samples: int, workers: int, rate: float | None) -> int:
    """Return the most samples of a unit in a round of ``samples``; ``rate``: of a worker, in samples a second."""
    most = FIRST_SAMPLES if rate is None else UNIT_SECONDS * rate
    return max(LEAST_SAMPLES, min(ceil(samples / (UNITS_PER_WORKER * max(workers, 1))), int(most)))


def divide(regions: Sequence[Region], counts: NDArray[np.uint32], most: int) -> list[Region]:
    """Return the regions, each cut into parts that get about equally many of ``counts`` (P,), at most ``most`` each.

    A pixel is never cut, so a part may have more if one of its pixels has.
    """
    found = []
    for region in regions:
        ends = np.cumsum(counts[region.first : region.first + region.size], dtype=np.int64)
        parts = max(1, ceil(int(ends[-1]) / most))
        shares = ends[-1] * np.arange(1, parts) // parts
        borders = np.unique([0, *np.searchsorted(ends, shares, side="left") + 1, region.size])
        for begin, end in itertools.pairwise(borders):
            part = replace(region, first=region.first + int(begin), size=int(end - begin))
            found.append(replace(part, skip=region.skip + int(begin)))
    return found
