"""How long a picture takes with more workers than there are here: a model of its parts, with measured constants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tracer.adaptive.schedule import round_goals
from tracer.cluster.work_balancer import LEAST_SECONDS, MOST_SECONDS, SCHEDULER_SECONDS, UNITS_PER_WORKER
from tracer.settings import make_settings

NETWORK = 1.25e9
"""Bytes a second that reach the client: ten gigabits, not measured here."""


@dataclass(frozen=True)
class Constants:
    """Seconds and bytes, as measured."""

    sample: float
    """Seconds of one thread for a sample, drawn and added."""
    unit: float
    """Seconds of client and scheduler for a unit."""
    deciding: float
    """Seconds of the client for a pixel and round."""
    developing: float
    """Seconds of the client for a pixel, to take in all sums and to make the picture, once."""
    round_bytes: float
    """That reach the client, for a pixel and round."""
    sums_bytes: float
    """That reach it for a pixel, once."""


@dataclass(frozen=True)
class Times:
    """Seconds of a picture, by what is waited for."""

    drawing: float
    """Workers, the last unit of each round included, while others have nothing to do."""
    scheduling: float
    """Beyond that, the scheduler, which cannot hand out units as fast as they are drawn."""
    deciding: float
    network: float
    developing: float

    @property
    def total(self) -> float:
        """All of them, one after the other."""
        return sum(vars(self).values())

    @property
    def limit(self) -> str:
        """What most of the time is waited for."""
        return max(vars(self), key=lambda name: vars(self)[name])


def times(constants: Constants, pixels: int, spp: int, workers: int) -> Times:
    """Return the times of a picture with workers of one thread, all alike."""
    goals = round_goals(make_settings(spp=spp), True, pixels)
    drawing = scheduling = 0.0
    for samples in (after - before for before, after in zip([0, *goals], goals, strict=False)):
        work = samples * constants.sample
        most = max(MOST_SECONDS, SCHEDULER_SECONDS * workers)
        unit = min(max(work / (UNITS_PER_WORKER * workers), LEAST_SECONDS, SCHEDULER_SECONDS * workers), most)
        # A unit is cut no smaller than a pixel; on average half of one is waited for.
        busy = work / workers + (unit / 2 if workers > 1 else 0.0)
        drawing += busy
        scheduling += max(work / unit * constants.unit - busy, 0.0)
    rounds = len(goals)
    return Times(
        drawing=drawing,
        scheduling=scheduling,
        deciding=(rounds - 1) * pixels * constants.deciding,
        network=pixels * (rounds * constants.round_bytes + constants.sums_bytes) / NETWORK,
        developing=pixels * constants.developing,
    )


def speed_up(constants: Constants, pixels: int, spp: int, workers: Sequence[int]) -> list[float]:
    """Return how many times as fast as one worker so many are."""
    alone = times(constants, pixels, spp, 1).total
    return [alone / times(constants, pixels, spp, count).total for count in workers]
