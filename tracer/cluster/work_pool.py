"""What is kept back of a round, for whoever is done first.

How long units take is foretold to a few percent, so what comes last is dealt out when it is seen who has time, in ever
smaller pieces (guided self-scheduling: C. Polychronopoulos and D. Kuck, 1987).
"""

from __future__ import annotations

from tracer.cluster.units import Unit, cut

KEPT_SHARE = 0.35
"""Of the time of a worker's units, what is kept back."""
LEAST_PIECE = 0.2
"""Seconds, below which nothing is cut."""
IN_HAND = 2
"""Units that a worker is given at a time in the end: it draws one, and another waits."""


class WorkPool:
    """Units that nobody was asked for yet."""

    def __init__(self) -> None:
        self.kept: dict[str, list[Unit]] = {}
        """By the worker that has their sums, the longest first."""

    def keep_back(self, worker: str, units: list[Unit]) -> list[Unit]:
        """Keep the last of a worker's units, the longest of which come first; return the others."""
        seconds_left = (1 - KEPT_SHARE) * sum(unit.seconds for unit in units)
        given = 0
        while given < len(units) and (given < IN_HAND or units[given].seconds <= seconds_left):
            seconds_left -= units[given].seconds
            given += 1
        self.kept[worker] = units[given:]
        return units[:given]

    def take(self, worker: str, worker_count: int) -> tuple[Unit | None, Unit | None]:
        """Return what a worker is to do next, None if nothing is kept, and what was cut off that, which is kept.

        ``worker_count``: those that share what is kept.
        """
        left = {name: sum(unit.seconds for unit in units) for name, units in self.kept.items() if units}
        if not left:
            return None, None
        units = self.kept[worker if worker in left else max(left, key=lambda name: left[name])]
        unit = units.pop(0)
        fair = max(sum(left.values()) / (IN_HAND * max(worker_count, 1)), LEAST_PIECE)
        if unit.seconds < 1.5 * fair:
            return unit, None
        rest = cut(unit, fair / unit.seconds)
        if rest is not None:
            units.insert(0, rest)
        return unit, rest
