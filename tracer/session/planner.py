"""Decide who gets the samples of a round, from all that is known when it begins."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from typing import Any

import numpy as np

from tracer.adaptive.allocation import decide, relative
from tracer.adaptive.decision import Decision, Situation
from tracer.adaptive.schedule import Schedule, first_samples
from tracer.adaptive.sharing import share_out
from tracer.complexity.pilot import Complexity
from tracer.core import parallel, threads
from tracer.core.arrays import Floats
from tracer.core.device import to_host
from tracer.core.smoothing import gaussian, smoothed
from tracer.criteria import Criterion, Evidence
from tracer.film import bias
from tracer.film.estimate import Estimate, Statistics
from tracer.image import objective
from tracer.scene.view import View
from tracer.session.first_look import FirstLook
from tracer.session.recorder import Recorder
from tracer.session.state import State
from tracer.settings import Settings

HELD_OUT_KEY = 0x5EED0
"""Keeps samples that only decide apart from those that make the picture."""


class Planner:
    """Plans every round of a render."""

    def __init__(
        self,
        view: View,
        settings: Settings,
        criterion: Criterion,
        weights: Floats,
        first_look: FirstLook,
        recorder: Recorder,
    ) -> None:
        """``weights`` (grid): what the person wants more of, see ``tracer.adaptive.importance_map``."""
        self.view, self.settings, self.criterion, self.weights = view, settings, criterion, weights
        self.first_look, self.recorder = first_look, recorder
        self.memory: dict[str, Any] = {}
        """What the criterion wants to find again in the next round."""
        self.weighed: tuple[Statistics, Floats] | None = None
        """What was known in the last decision, and the objective's weights of it."""

    @property
    def holds_out(self) -> bool:
        """Whether samples that decide are kept out of the picture."""
        return self.settings.unbiased and self.criterion.needs_radiance and not self.settings.too_small

    @property
    def loses_light(self) -> bool:
        """Whether samples that decide are in the picture, in such a way that the bias can be measured."""
        return self.criterion.needs_radiance and self.criterion.spends == "deviation" and not self.settings.unbiased

    def seed(self, state: State) -> int:
        """Return the seed of the samples that are drawn now."""
        decides = self.holds_out and state.held_out is None
        return self.settings.seed ^ HELD_OUT_KEY if decides else self.settings.seed

    def plan(self, state: State, schedule: Schedule, goal: int, make_empty: Callable[[], Estimate]) -> None:
        """Decide who gets the samples of a round that ends with ``goal`` of them in all.

        ``make_empty`` makes an estimate without samples, for those that are in the picture where others have decided.
        """
        known = None
        if state.done > 0 and self.criterion.needs_radiance:
            with self.recorder.timing("seconds_statistics"):
                known = state.estimate.statistics()
        if self.holds_out and schedule.is_last(goal) and state.held_out is None:
            self.hold_out(state, make_empty())
        if state.held_out is not None:
            goal -= int(state.held_out_samples)
        if self.loses_light and known is not None:
            so_far = state.unbiased or bias.UnbiasedMean.nothing(self.view.grid, len(self.view.channels))
            state.unbiased = so_far.after(state.before, known)
        with self.recorder.timing("seconds_deciding"):
            decision = self.decide(state, schedule, known, goal)
        state.before, state.allocation, state.chance = known, decision.allocation, decision.chance

    def hold_out(self, state: State, empty: Estimate) -> None:
        """Put aside all samples drawn so far, and draw others from here on."""
        state.held_out, state.estimate = state.estimate, empty
        state.held_out_samples = state.done
        state.drawn = np.zeros(self.view.grid, np.uint32)
        self.recorder.report.note(
            f"Unbiased: {state.done // self.view.pixel_count} samples per pixel decided and are not in the picture."
        )

    def decide(self, state: State, schedule: Schedule, known: Statistics | None, goal: int) -> Decision:
        """Return how many samples each pixel is to have when ``goal`` are drawn; ``known``: of the samples so far."""
        settings, budget = self.settings, schedule.budget
        total = goal if state.held_out is not None else budget
        horizon = goal if settings.is_open else total
        may_settle = not (settings.unbiased or settings.is_open)
        situation = Situation(state.drawn, goal, total, may_settle, horizon, self.view.object_count)
        if self.criterion.needs_radiance and (known is None or self.is_to_learn(state, goal)):
            even = np.ones(self.view.grid) if goal < budget else self.weights
            return Decision(share_out(even, even, settings, situation, False, state.generator))
        with nullcontext() if self.criterion.is_built_in else threads.for_files():  # others may read files
            decision = decide(self.criterion, self.evidence(state, known), settings, situation, state.generator)
        state.importance = None if decision.importance is None else relative(decision.importance)
        if decision.note:
            self.recorder.report.note(decision.note, once=decision.note.partition(" ")[0])
        return decision

    def is_to_learn(self, state: State, goal: int) -> bool:
        """Return whether a round that ends with ``goal`` samples is there to learn from: all pixels get the same."""
        if state.held_out is not None:
            return False
        return self.holds_out or goal <= first_samples(self.settings, self.criterion) * self.view.pixel_count

    def evidence(self, state: State, known: Statistics | None) -> Evidence:
        """Return what a criterion decides by."""
        before = state.before

        def look() -> Complexity:
            state.looked = True
            return self.first_look.complexity

        weight_before = None if before is None else self.objective_weight(before)
        weight = self.objective_weight(known)
        return Evidence(
            look=look,
            statistics=known,
            before=before,
            weight=weight,
            weight_before=weight_before,
            colour_channels=self.view.colour_channels,
            wanted=self.weights,
            memory=self.memory,
        )

    def objective_weight(self, known: Statistics | None) -> Floats:
        """Return the objective's weight of each pixel (grid), up to a factor that all of them share.

        It is that of the mean, smoothed as the film's filter will smooth it.
        """
        if known is None:
            return np.ones(self.view.grid)
        if self.weighed is None or self.weighed[0] is not known:
            (smooth_brightness,) = smoothed(self.view.luminance_on_device(known.mean), self.view.grid, gaussian(1.0))
            smooth = to_host(smooth_brightness, self.view.grid)
            weights = parallel.fill(np.empty(self.view.grid), self.weights_at, smooth)
            self.weighed = known, objective.without_scale(weights)
        return self.weighed[1]

    def weights_at(self, luminance: Floats) -> Floats:
        """Return the objective's weights of pixels (any shape) of this luminance."""
        return objective.weights(self.settings.objective, luminance, self.settings.exposure)
