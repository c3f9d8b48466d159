"""A model, with measured constants, of the time that a picture takes with more workers than were measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tracer import criteria
from tracer.adaptive.schedule import round_goals
from tracer.cluster.work_balancer import LEAST_SECONDS, MOST_SECONDS, SCHEDULER_SECONDS, UNITS_PER_WORKER
from tracer.settings import make_settings

NETWORK = 1.25e9
"""Bytes a second that the client can receive: ten gigabits a second, an assumption and not measured."""


@dataclass(frozen=True)
class Constants:
    """Measured constants of the model, in seconds and bytes."""

    sample: float
    """Seconds of one thread to draw a sample and to add it."""
    unit: float
    """Seconds of client and scheduler for a unit of work."""
    deciding: float
    """Seconds of the client to decide on a pixel, in each round."""
    developing: float
    """Seconds of the client to take in all sums of a pixel and to develop it, once."""
    round_bytes: float
    """Bytes that the client receives for a pixel, in each round."""
    sums_bytes: float
    """Bytes of the sums that the client receives for a pixel, once."""


@dataclass(frozen=True)
class Times:
    """Seconds of waiting for each part of the work on a picture."""

    drawing: float
    """Waiting for workers, including the last units of each round, while other workers have nothing to do."""
    scheduling: float
    """Additional waiting for the scheduler, if it cannot hand out units as fast as they are drawn."""
    deciding: float
    """Waiting for the client to allocate rounds."""
    network: float
    """Waiting for bytes to reach the client."""
    developing: float
    """Waiting for the client to take in all sums and to develop the picture."""

    @property
    def total(self) -> float:
        """Sum of all parts, which follow one another."""
        return sum(vars(self).values())

    @property
    def limit(self) -> str:
        """Name of the part that takes the longest."""
        return max(vars(self), key=lambda name: vars(self)[name])


def times(constants: Constants, pixels: int, spp: int, workers: int) -> Times:
    """Return the times of a picture with identical workers of one thread each."""
    goals = round_goals(make_settings(spp=spp), criteria.get("fused"), pixels)
    drawing = scheduling = 0.0
    for samples in (after - before for before, after in zip([0, *goals], goals, strict=False)):
        thread_seconds = samples * constants.sample
        longest_unit = max(MOST_SECONDS, SCHEDULER_SECONDS * workers)
        unit_seconds = min(
            max(thread_seconds / (UNITS_PER_WORKER * workers), LEAST_SECONDS, SCHEDULER_SECONDS * workers), longest_unit
        )
        # A unit has at least one pixel; at the end of a round, half a unit is waited for on average.
        busy_seconds = thread_seconds / workers + (unit_seconds / 2 if workers > 1 else 0.0)
        drawing += busy_seconds
        scheduling += max(thread_seconds / unit_seconds * constants.unit - busy_seconds, 0.0)
    rounds = len(goals)
    return Times(
        drawing=drawing,
        scheduling=scheduling,
        deciding=(rounds - 1) * pixels * constants.deciding,
        network=pixels * (rounds * constants.round_bytes + constants.sums_bytes) / NETWORK,
        developing=pixels * constants.developing,
    )


def speed_up(constants: Constants, pixels: int, spp: int, workers: Sequence[int]) -> list[float]:
    """Return, for each number of workers, how many times as fast as one worker they are."""
    alone = times(constants, pixels, spp, 1).total
    return [alone / times(constants, pixels, spp, count).total for count in workers]
