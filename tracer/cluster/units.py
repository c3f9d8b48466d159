"""The pieces that a round is cut into, and whom they are asked of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tracer.cluster.work_balancer import Region, divide, split_at
from tracer.core.arrays import Counts


@dataclass(eq=False)
class Unit:
    """Samples of consecutive pixels that one worker draws."""

    region: Region
    counts: Counts
    """(P,): samples to draw."""
    goal: Counts
    """(P,): samples there are to be afterwards."""
    seconds: float = 0.0
    """It is expected to take."""
    scene_tries: int = 0
    """How often it was asked for again because a worker had no scene for it."""
    requests: list[UnitRequest] = field(default_factory=list)
    """Those that may still be answered; the first answer counts."""


@dataclass(eq=False)
class UnitRequest:
    """A worker is asked for a unit."""

    unit: Unit
    worker: str | None
    """Whoever has time, if None."""
    anew: bool
    """All samples of the pixels are drawn, from the first, as the sums of earlier rounds may be lost."""
    sent: float
    """When, in seconds of the clock that the policy is told."""
    futures: tuple[Any, Any] | None = None
    """What whoever sends it will know of it: what is drawn, and what is reported of that. Nothing here looks at it."""

    @property
    def is_open(self) -> bool:
        """Whether an answer still matters: not if another worker was faster, or if it was given up."""
        return self in self.unit.requests

    @property
    def needs_sums(self) -> bool:
        """Whether it goes on from sums that a worker has."""
        return not self.anew and self.unit.region.source is not None


def cut_round(
    regions: Sequence[Region], counts: Counts, goal: Counts, worker_count: int
) -> tuple[list[Region], list[Unit]]:
    """Return the regions, cut where they would take too long, and a unit for each that has samples to draw.

    ``counts`` (P,): samples to draw, ``goal`` (P,): samples there are to be, both of the whole picture.
    """
    parts = divide(regions, counts, worker_count)
    units = [Unit(part, counts[part.pixels], goal[part.pixels]) for part in parts if counts[part.pixels].any()]
    return parts, units


def cut(unit: Unit, share: float) -> Unit | None:
    """Leave a unit, for which nobody was asked yet, about a share of its samples; return one with the rest, if any."""
    parts = split_at(unit.region, unit.counts, [share])
    if len(parts) < 2:
        return None
    at = parts[0].size
    seconds = unit.seconds * sample_count(unit.counts[:at]) / max(sample_count(unit.counts), 1)
    rest = Unit(parts[1], unit.counts[at:], unit.goal[at:], unit.seconds - seconds)
    unit.region, unit.counts, unit.goal, unit.seconds = parts[0], unit.counts[:at], unit.goal[:at], seconds
    return rest


def sample_count(counts: Counts) -> int:
    """Return the sum of counts."""
    return int(counts.sum(dtype=np.int64))
