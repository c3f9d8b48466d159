"""The rounds of a render: how large each one is, and when there is no further round."""

from __future__ import annotations

from math import sqrt

from tracer.adaptive.convergence import Noise
from tracer.adaptive.prediction import cost_of_pass
from tracer.adaptive.stopping import Clock, Reason, next_goal
from tracer.criteria import Criterion
from tracer.settings import Settings

GROWTH = 2.0
"""Factor, about, by which a round increases the samples drawn."""
PRIORITY_GROWTH = 1.3
"""The same factor for criteria that serve pixels by priority: a pixel served gets as many samples again as it has, so
that a round serves a few pixels only."""
FIRST_SAMPLES = 8
"""Samples per pixel of the first round of criteria that share out samples by deviation, if that leaves at least as many
to share out. Four samples tell a deviation so badly that at 16 samples per pixel, in the same time, less
than half is gained."""

TYPICAL_WORK, MOST_LOST = 8.0, 0.04
"""What a sample is taken to cost before any is drawn, and the part of a picture's time that a first decision may
take: it may be in vain."""


def first_samples(settings: Settings, criterion: Criterion) -> int:
    """Return the samples per pixel of the first round of a criterion that learns from radiance."""
    may_choose = settings.pilot_spp is None and not settings.unbiased
    if criterion.spends == "deviation" and may_choose and settings.spp >= 2 * FIRST_SAMPLES:
        return FIRST_SAMPLES
    return settings.pilot_samples


def leaves_no_time(settings: Settings, criterion: Criterion, pixel_count: int, object_count: int) -> bool:
    """Return whether to decide at all would cost too much: a small picture of a scene of many shapes.

    ``object_count``: number of shapes and lights of the scene. A person who asks for first samples gets them.
    """
    may_choose = settings.pilot_spp is None and not settings.unbiased and not settings.is_open
    if not may_choose or criterion.spends != "deviation" or not criterion.needs_radiance:
        return False
    work = TYPICAL_WORK * settings.spp * pixel_count
    return cost_of_pass(object_count) > MOST_LOST * work


def round_goals(settings: Settings, criterion: Criterion, pixel_count: int, object_count: int = 0) -> list[int]:
    """Return the samples drawn in all, of all pixels together, after each round.

    A criterion that learns from radiance gets a first round that is the same for all pixels, and then rounds that
    multiply the samples by about GROWTH. Only the last round may grow by less or more, so that a larger budget begins
    in the same way. If the samples that decide are left out of the picture, there are two equal rounds and a last one.
    Other criteria have one round, unless something else than the budget may end the render; so has a budget that leaves
    nothing to decide, or no time for it. Where time is limited, there is an additional first round with one sample per
    pixel.
    """
    growth = PRIORITY_GROWTH if criterion.spends == "priority" else GROWTH
    spp, first = settings.spp, first_samples(settings, criterion)
    no_time = leaves_no_time(settings, criterion, pixel_count, object_count)
    if settings.too_small or no_time or not (criterion.needs_radiance or settings.is_open):
        goals: list[float] = [spp]
    elif settings.unbiased and criterion.needs_radiance:
        goals = [first, 2 * first, spp]
    else:
        goals = [first]
        while goals[-1] * growth <= spp / sqrt(growth):
            goals.append(goals[-1] * growth)
        goals.append(spp)
    if settings.time is not None and goals[0] > 1:
        goals.insert(0, 1)
    return [round(goal * pixel_count) for goal in goals]


class Schedule:
    """Decides whether another round is drawn, and how large it is, until there is a reason to stop."""

    def __init__(
        self, settings: Settings, criterion: Criterion, pixel_count: int, clock: Clock, object_count: int = 0
    ) -> None:
        """``clock``: has the limit of time, if there is one; ``object_count``: as for ``leaves_no_time``."""
        self.settings, self.pixel_count, self.clock = settings, pixel_count, clock
        self.object_count = object_count
        self.goals = round_goals(settings, criterion, pixel_count, object_count)
        self.noise: Noise | None = None
        """The noise that was measured last; None before that."""
        self.stopped_by: Reason | None = None

    @property
    def measures_noise(self) -> bool:
        """Whether the noise of the picture is measured after each round."""
        return self.settings.noise is not None

    @property
    def budget(self) -> int:
        """The most samples that are drawn, of all pixels together."""
        return self.settings.spp * self.pixel_count

    def why_uniform(self) -> str:
        """Return a sentence on why a criterion that learns from radiance has a single round."""
        spp, first = self.settings.spp, self.settings.pilot_samples
        if self.settings.too_small:
            return (
                f"Uniform: {spp} spp leave nothing to decide after a first look with {first} samples per pixel; use a "
                "larger spp or set pilot_spp."
            )
        return (
            f"Uniform: with {self.object_count} shapes and lights, a decision takes much of the time of so small a "
            "picture; set pilot_spp to decide all the same."
        )

    def next_goal(self, done: int) -> int | None:
        """Return the samples that are to be drawn in all after the next round; None if there is a reason to stop.

        ``done``: samples drawn so far, of all pixels together.
        """
        if self.stopped_by is not None:
            return None
        goal, self.stopped_by = next_goal(self.goals, done, self.settings, self.noise, self.clock)
        return goal

    def stop(self, reason: Reason) -> None:
        """Let the render end after the pass that was drawn last."""
        self.stopped_by = reason

    def is_last(self, goal: int) -> bool:
        """Return whether a round that ends with ``goal`` samples spends the whole budget."""
        return goal == self.goals[-1]
