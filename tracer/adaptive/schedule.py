"""How a budget is cut up in time: rounds between decisions, passes between signs of life."""

from __future__ import annotations

from math import sqrt

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
