"""The pieces that a round is cut into, and the requests to workers to draw them."""

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
    """(P,): samples that the pixels are to have afterwards."""
    seconds: float = 0.0
    """Seconds that the unit is expected to take."""
    scene_tries: int = 0
    """How often the unit was asked for again because a worker had no scene."""
    requests: list[UnitRequest] = field(default_factory=list)
    """Requests that may still be answered; the first answer counts."""


@dataclass(eq=False)
class UnitRequest:
    """A request to a worker to draw a unit."""

    unit: Unit
    worker: str | None
    """Address of the worker that is asked; None: any worker."""
    anew: bool
    """Whether all samples of the pixels are drawn, from the first, as the sums of earlier rounds may be lost."""
    sent: float
    """Time at which it was made, in seconds of the clock that the policy's caller has."""
    futures: tuple[Any, Any] | None = None
    """Futures of what is drawn, and of what is reported of that. The sender of the request sets and uses them."""

    @property
    def is_open(self) -> bool:
        """Whether an answer still matters: False if another worker was faster, or if the request was withdrawn."""
        return self in self.unit.requests

    @property
    def needs_sums(self) -> bool:
        """Whether the samples are added to sums that a worker has."""
        return not self.anew and self.unit.region.source is not None


def cut_round(
    regions: Sequence[Region], counts: Counts, goal: Counts, worker_count: int
) -> tuple[list[Region], list[Unit]]:
    """Return the regions, those that would take too long in parts, and a unit for each region with samples to draw.

    ``counts`` (P,): samples to draw; ``goal`` (P,): samples that pixels are to have afterwards; both of the whole
    picture.
    """
    parts = divide(regions, counts, worker_count)
    units = [Unit(part, counts[part.pixels], goal[part.pixels]) for part in parts if counts[part.pixels].any()]
    return parts, units


def cut(unit: Unit, share: float) -> Unit | None:
    """Leave a unit about a ``share`` of its samples, and return a unit with the rest; None if it cannot be cut.

    No worker may have been asked for the unit yet.
    """
    parts = split_at(unit.region, unit.counts, [share])
    if len(parts) < 2:
        return None
    size = parts[0].size
    seconds = unit.seconds * sample_count(unit.counts[:size]) / max(sample_count(unit.counts), 1)
    rest = Unit(parts[1], unit.counts[size:], unit.goal[size:], unit.seconds - seconds)
    unit.region, unit.counts, unit.goal, unit.seconds = parts[0], unit.counts[:size], unit.goal[:size], seconds
    return rest


def sample_count(counts: Counts) -> int:
    """Return the number of samples that counts (P,) add up to."""
    return int(counts.sum(dtype=np.int64))
