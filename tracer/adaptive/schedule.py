"""How a budget is cut up in time: which rounds there are between decisions, and when there is none any more."""

from __future__ import annotations

from math import sqrt

from tracer.adaptive.convergence import Noise
from tracer.adaptive.stopping import Clock, Reason, next_goal
from tracer.criteria import Criterion
from tracer.settings import Settings

GROWTH = 2.0
"""After a round there are about this many times the samples that were there before it."""


PRIORITY_GROWTH = 1.3
"""The same where pixels are served by priority: those that are get as many again as they have, so that it is a few."""


def round_goals(settings: Settings, needs_radiance: bool, pixel_count: int, growth: float = GROWTH) -> list[int]:
    """Return the samples drawn in all after each round.

    A criterion that learns gets a round that is the same for all pixels, and then such as grow by ``growth``; only the
    last may grow by less or more, so that a larger budget begins in the same way. If those that taught are to be held
    out there are two equal ones and a last one. Others have one round, unless more than the budget may end the render,
    and so has a budget that leaves nothing to decide. Where time is limited, a first round has one sample a pixel.
    """
    spp, pilot = settings.spp, settings.pilot_samples
    if settings.too_small or not (needs_radiance or settings.is_open):
        goals: list[float] = [spp]
    elif settings.unbiased and needs_radiance:
        goals = [pilot, 2 * pilot, spp]
    else:
        goals = [pilot]
        while goals[-1] * growth <= spp / sqrt(growth):
            goals.append(goals[-1] * growth)
        goals.append(spp)
    if settings.time is not None and goals[0] > 1:
        goals.insert(0, 1)
    return [round(goal * pixel_count) for goal in goals]


class Schedule:
    """Says whether another round is drawn, and how large it is, until there is a reason to stop."""

    def __init__(
        self, settings: Settings, criterion: Criterion, pixel_count: int, clock: Clock, measures_noise: bool
    ) -> None:
        """``clock``: has the limit of time, if there is one; ``measures_noise``: whether that is done after rounds."""
        growth = PRIORITY_GROWTH if criterion.spends == "priority" else GROWTH
        self.settings, self.pixel_count, self.clock = settings, pixel_count, clock
        self.goals = round_goals(settings, criterion.needs_radiance, pixel_count, growth)
        self.measures_noise = measures_noise
        self.noise: Noise | None = None
        """What was measured last, if it is measured."""
        self.stopped_by: Reason | None = None

    @property
    def budget(self) -> int:
        """The most samples that are drawn in all."""
        return self.settings.spp * self.pixel_count

    def next_goal(self, done: int) -> int | None:
        """Return how many samples there are to be after the next round; None if there is a reason to stop."""
        if self.stopped_by is not None:
            return None
        goal, self.stopped_by = next_goal(self.goals, done, self.settings, self.noise, self.clock)
        return goal

    def is_last(self, goal: int) -> bool:
        """Return whether a round that ends with ``goal`` samples spends the budget."""
        return goal == self.goals[-1]
