"""Units of a round that are kept back for the workers that are done first.

The time of a unit is predicted only to a few percent. So the last units are dealt out when it is known which workers
have time, in ever smaller pieces (guided self-scheduling: C. Polychronopoulos and D. Kuck, 1987).
"""

from __future__ import annotations

from tracer.cluster.units import Unit, cut

KEPT_SHARE = 0.35
"""Share that is kept back, of the time of a worker's units."""
LEAST_PIECE = 0.2
"""Least seconds that a unit is cut down to."""
IN_HAND = 2
"""Number of units that a worker has at a time at the end of a round: it draws one, and the other waits."""


class WorkPool:
    """Units that no worker was asked for yet."""

    def __init__(self) -> None:
        self.kept: dict[str, list[Unit]] = {}
        """Units that are kept back, by the worker that they were dealt to, the longest first."""

    def keep_back(self, worker: str, units: list[Unit]) -> list[Unit]:
        """Keep the last of a worker's ``units``, which are in order with the longest first; return the others."""
        seconds_left = (1 - KEPT_SHARE) * sum(unit.seconds for unit in units)
        given = 0
        while given < len(units) and (given < IN_HAND or units[given].seconds <= seconds_left):
            seconds_left -= units[given].seconds
            given += 1
        self.kept[worker] = units[given:]
        return units[:given]

    def take(self, worker: str, worker_count: int) -> tuple[Unit | None, Unit | None]:
        """Return the unit that a worker is to draw next, and the rest that was cut off it and stays in the pool.

        The unit is None if the pool is empty; the rest is None if nothing was cut off. ``worker_count``: number of
        workers that share the pool.
        """
        left = {name: sum(unit.seconds for unit in units) for name, units in self.kept.items() if units}
        if not left:
            return None, None
        units = self.kept[worker if worker in left else max(left, key=lambda name: left[name])]
        unit = units.pop(0)
        fair_seconds = max(sum(left.values()) / (IN_HAND * max(worker_count, 1)), LEAST_PIECE)
        if unit.seconds < 1.5 * fair_seconds:
            return unit, None
        rest = cut(unit, fair_seconds / unit.seconds)
        if rest is not None:
            units.insert(0, rest)
        return unit, rest
