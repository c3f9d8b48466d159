"""When a render is over: its samples are spent, the picture is good enough, or time is up."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Literal

from tracer.adaptive.convergence import Noise
from tracer.settings import Settings

Reason = Literal["spp", "noise", "time", "person"]
"""What ended a render: the budget, the noise target, the time, or a person."""

LEAST_SPP = 16
"""Mean samples per pixel before which a noise target is not met: light that is rare is not seen sooner."""
MARGIN = 1.05
"""Samples beyond those that a noise target seems to need."""
LEAST_GROWTH = 1.2
"""Of a round, where a noise target asks for little more: deciding and measuring cost as much as a few samples."""
WORTHWHILE = 0.05
"""Least part of the samples so far for which another round is begun in the time that is left."""
SAFETY = 0.9
"""Part of the time left that a round is planned for."""
MEMORY = 0.8
"""Weight of all earlier passes against the last one in the rate of samples."""
SECONDS_PER_PIXEL = 2e-6
"""To write a picture, and"""
SECONDS_TO_END = 0.3
"""to end the program."""


class Clock:
    """Time spent and time left."""

    def __init__(self, limit: float | None, started: float, pixel_count: int) -> None:
        """``started``: value of ``time.perf_counter()`` from which ``limit`` seconds count."""
        reserve = SECONDS_TO_END + SECONDS_PER_PIXEL * pixel_count
        self.began, self.end = started, None if limit is None else started + limit - reserve
        self.last = time.perf_counter()
        self.first = True
        self.pass_seconds = 0.0
        self.samples = 0.0
        self.seconds = 0.0

    def keep_back(self, seconds: float) -> None:
        """Keep so many seconds more for the end."""
        if self.end is not None:
            self.end -= seconds

    def passed(self, samples: int) -> None:
        """Note a pass, with all that was done since the one before."""
        now = time.perf_counter()
        self.pass_seconds = now - self.last
        # The first pass compiles: it says little of the others.
        keep = 0.0 if self.first or self.samples < 0 else MEMORY
        self.first, self.last = self.samples == 0, now
        self.samples = keep * self.samples + samples
        self.seconds = keep * self.seconds + self.pass_seconds

    def seconds_for(self, samples: float) -> float | None:
        """Return the seconds that some more samples will take; None before there was a pass."""
        return None if self.samples == 0 else samples * self.seconds / self.samples

    def samples_left(self) -> float:
        """Return how many samples fit in the time that is left."""
        left = self.seconds_left()
        return left if left == float("inf") else left * self.samples / max(self.seconds, 1e-9)

    def seconds_left(self) -> float:
        """Return the seconds that are left for drawing."""
        return float("inf") if self.end is None else max(self.end - time.perf_counter(), 0.0)

    def share_over(self) -> float:
        """Return the part of the time that is over, 0 to 1; 0 where it is not limited."""
        if self.end is None:
            return 0.0
        return min(max(time.perf_counter() - self.began, 0.0) / max(self.end - self.began, 1e-9), 1.0)

    def is_over(self) -> bool:
        """Return whether there is no time for another pass."""
        return self.end is not None and time.perf_counter() + self.pass_seconds > self.end


def next_goal(
    goals: Sequence[int], done: int, settings: Settings, noise: Noise | None, clock: Clock
) -> tuple[int | None, Reason | None]:
    """Return the samples that there are to be after the next round, or None and why there is none."""
    goal = next((goal for goal in goals if goal > done), None)
    needed = float("inf")
    early = done * settings.spp < LEAST_SPP * goals[-1]
    if settings.noise is not None and noise is not None and noise.measured and not early:
        if noise.error <= settings.noise:
            return None, "noise"
        needed = done * max(MARGIN * noise.needed, LEAST_GROWTH)
    if goal is None:
        return None, "spp"
    goal = min(goal, round(min(needed, goals[-1])))
    if settings.time is not None and done > 0:
        left = clock.samples_left()
        if left < WORTHWHILE * done:
            return None, "time"
        goal = min(goal, done + max(int(SAFETY * left), 1))
    return goal, None
