"""When a render is over: its budget is spent, its picture is good enough, or its time is up."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Literal

from tracer.adaptive.convergence import Noise
from tracer.settings import Settings

Reason = Literal["spp", "noise", "time", "person"]
"""What ended a render: the budget, the noise target, the time, or a person."""

LEAST_SPP = 16
"""Mean samples per pixel before which no noise target counts as met, as rare light is not seen sooner."""
MARGIN = 1.05
"""Samples that are planned for a noise target, over those that it seems to need."""
LEAST_GROWTH = 1.2
"""Least factor by which a round increases the samples if a noise target needs little more: deciding and measuring cost
as much as a few samples."""
WORTHWHILE = 0.05
"""Least part of the samples drawn so far that must fit in the time that is left for another round to begin."""
SAFETY = 0.9
"""Part of the time that is left for which a round is planned."""
MEMORY = 0.8
"""Weight of all earlier passes in the rate of samples, relative to the last pass."""
SECONDS_PER_PIXEL = 2e-6
"""Seconds that are kept back for writing the picture, per pixel."""
SECONDS_TO_END = 0.3
"""Seconds that are kept back for ending the program."""


class Clock:
    """Keeps the time that is spent and the time that is left, and the rate of samples."""

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
        """Keep back this many more seconds for the end of the render."""
        if self.end is not None:
            self.end -= seconds

    def passed(self, samples: int) -> None:
        """Note that a pass of ``samples`` has ended; its time is all that has passed since the one before."""
        now = time.perf_counter()
        self.pass_seconds = now - self.last
        # The first pass includes compiling, and so says little about the others.
        weight = 0.0 if self.first or self.samples < 0 else MEMORY
        self.first, self.last = self.samples == 0, now
        self.samples = weight * self.samples + samples
        self.seconds = weight * self.seconds + self.pass_seconds

    @property
    def knows_rate(self) -> bool:
        """Whether a pass has been timed."""
        return self.samples > 0

    def seconds_for(self, samples: float) -> float | None:
        """Return the seconds that ``samples`` more samples will take; None before the first pass."""
        return samples * self.seconds / self.samples if self.knows_rate else None

    def samples_left(self) -> float:
        """Return how many samples fit in the time that is left; infinity if time is not limited."""
        seconds = self.seconds_left()
        return seconds if seconds == float("inf") else seconds * self.samples / max(self.seconds, 1e-9)

    def seconds_left(self) -> float:
        """Return the seconds that are left for drawing samples; infinity if time is not limited."""
        return float("inf") if self.end is None else max(self.end - time.perf_counter(), 0.0)

    def share_over(self) -> float:
        """Return the part of the time that is over, 0 to 1; 0 if time is not limited."""
        if self.end is None:
            return 0.0
        return min(max(time.perf_counter() - self.began, 0.0) / max(self.end - self.began, 1e-9), 1.0)

    def is_over(self) -> bool:
        """Return whether there is no time for another pass."""
        return self.end is not None and time.perf_counter() + self.pass_seconds > self.end


def next_goal(
    goals: Sequence[int], done: int, settings: Settings, noise: Noise | None, clock: Clock
) -> tuple[int | None, Reason | None]:
    """Return the samples that are to be drawn in all after the next round, or None; and for None the reason to stop.

    ``goals``: samples in all after each round, see ``round_goals``; ``done``: samples drawn so far.
    """
    goal = next((goal for goal in goals if goal > done), None)
    needed = float("inf")
    is_early = done * settings.spp < LEAST_SPP * goals[-1]
    if settings.noise is not None and noise is not None and noise.measured and not is_early:
        if noise.error <= settings.noise:
            return None, "noise"
        needed = done * max(MARGIN * noise.needed, LEAST_GROWTH)
    if goal is None:
        return None, "spp"
    goal = min(goal, round(min(needed, goals[-1])))
    if settings.time is not None and done > 0 and clock.knows_rate:
        samples_left = clock.samples_left()
        if samples_left < WORTHWHILE * done:
            return None, "time"
        goal = min(goal, done + max(int(SAFETY * samples_left), 1))
    elif done > 0 and clock.seconds_left() == 0:  # a render that goes on from a checkpoint has timed no pass yet
        return None, "time"
    return goal, None
