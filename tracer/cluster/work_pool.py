"""What is kept back of a round, for whoever is done first.

How long units take is foretold to a few percent, so what comes last is dealt out when it is seen who has time, in ever
smaller pieces (guided self-scheduling: C. Polychronopoulos and D. Kuck, 1987).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tracer.cluster.work_balancer import Region, split_at
from tracer.core.arrays import Counts

KEPT_SHARE = 0.35
"""Of the time of a worker's units."""
LEAST_PIECE = 0.2
"""Seconds, below which nothing is cut."""
IN_HAND = 2
"""Units that a worker is given at a time in the end: it draws one, and another waits."""


@dataclass(eq=False)
class Unit:
    """Samples of consecutive pixels, and the futures that will know of them."""

    region: Region
    counts: Counts
    """(P,): samples to draw."""
    goal: Counts
    """(P,): samples there are to be afterwards."""
    seconds: float = 0.0
    """It is expected to take."""
    sent: float = 0.0
    """When it was sent last."""
    tries: int = 0
    """Workers that had no scene for it."""
    futures: list[tuple[Any, Any]] = field(default_factory=list)
    """What is drawn, and what is told of it: by the first that was asked, and by others that draw all samples anew."""


class Pool:
    """Units that are not given to anybody yet, and who works on those that are."""

    def __init__(self) -> None:
        self.kept: dict[str, list[Unit]] = {}
        """By the worker that has their sums, the longest first."""
        self.at_work: dict[str, set[Unit]] = {}

    def keep_back(self, worker: str, units: list[Unit]) -> list[Unit]:
        """Keep the last of a worker's units, the longest of which come first; return the others."""
        left = (1 - KEPT_SHARE) * sum(unit.seconds for unit in units)
        given = 0
        while given < len(units) and (given < IN_HAND or units[given].seconds <= left):
            left -= units[given].seconds
            given += 1
        self.kept[worker] = units[given:]
        return units[:given]

    def gave(self, worker: str, units: Iterable[Unit]) -> None:
        """Note that a worker was given units."""
        self.at_work.setdefault(worker, set()).update(units)

    def done(self, unit: Unit) -> list[str]:
        """Note that a unit is done; return who was given it."""
        given = [worker for worker, several in self.at_work.items() if unit in several]
        for worker in given:
            self.at_work[worker].remove(unit)
        return given

    def take(self, worker: str) -> tuple[Unit | None, Unit | None]:
        """Return what a worker is to do next, and what was cut off that, which is kept; None: it has enough."""
        if len(self.at_work.get(worker, ())) >= IN_HAND:
            return None, None
        left = {name: sum(unit.seconds for unit in units) for name, units in self.kept.items() if units}
        if not left:
            return None, None
        units = self.kept[worker if worker in left else max(left, key=lambda name: left[name])]
        unit = units.pop(0)
        fair = max(sum(left.values()) / (IN_HAND * max(len(self.at_work), 1)), LEAST_PIECE)
        if unit.seconds < 1.5 * fair:
            return unit, None
        rest = cut(unit, fair / unit.seconds)
        if rest is not None:
            units.insert(0, rest)
        return unit, rest


def cut(unit: Unit, share: float) -> Unit | None:
    """Leave a unit, for which nobody was asked yet, about a share of its samples; return one with the rest, if any."""
    parts = split_at(unit.region, unit.counts, [share])
    if len(parts) < 2:
        return None
    at = parts[0].size
    seconds = unit.seconds * samples(unit.counts[:at]) / max(samples(unit.counts), 1)
    rest = Unit(parts[1], unit.counts[at:], unit.goal[at:], unit.seconds - seconds)
    unit.region, unit.counts, unit.goal, unit.seconds = parts[0], unit.counts[:at], unit.goal[:at], seconds
    return rest


def samples(counts: Counts) -> int:
    """Return the sum of counts."""
    return int(counts.sum(dtype=np.int64))
