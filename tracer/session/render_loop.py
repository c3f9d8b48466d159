"""The loop: look, decide, draw, and again with what was learned."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import closing, suppress
from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from tracer import criteria
from tracer.adaptive.allocation import Decision, Situation, decide, relative, share_out
from tracer.adaptive.convergence import Noise
from tracer.adaptive.importance_map import wanted
from tracer.adaptive.schedule import GROWTH, PRIORITY_GROWTH, round_goals
from tracer.adaptive.stopping import Clock, next_goal
from tracer.complexity import pilot
from tracer.core import threads
from tracer.denoising.oidn import load as load_denoiser
from tracer.denoising.postprocess import see, without_noise
from tracer.denoising.residual_noise import Leftover
from tracer.errors import ClusterError, PendingWriteError
from tracer.film import bias
from tracer.film.estimate import Estimate, Statistics
from tracer.image import objective
from tracer.progress import Course, Progress
from tracer.result import Report, Result, Round
from tracer.scene.view import View
from tracer.session import memory
from tracer.session.local_drawer import Drawer, Here
from tracer.session.state import State
from tracer.session.terms import PLAIN, Terms
from tracer.settings import Settings

FEATURE_SECONDS, DENOISE_SECONDS = 6e-6, 8e-6
"""A pixel, kept back for the end where time is limited."""
HELD_OUT_KEY = 0x5EED0
"""Keeps samples that only decide apart from those that make the picture."""


def render_view(view: View, settings: Settings, terms: Terms = PLAIN, importance: Any = None) -> Result:
    """Render an open scene; see ``tracer.render``. Raises CheckpointError if the state kept is of another render."""
    with dr.suspend_grad():
        rendering = Rendering(view, settings, terms, importance)
        try:
            return rendering.run()
        finally:
            rendering.drawer.close()


class Rendering:
    """One render under way."""

    def __init__(self, view: View, settings: Settings, terms: Terms = PLAIN, importance: Any = None) -> None:
        self.start = time.perf_counter()
        self.view, self.settings, self.terms = view, settings, terms
        self.keeper = keeper = terms.keeper
        denoises = settings.objective == "denoised"
        if terms.denoise or denoises:
            load_denoiser()  # before the work, not after
        self.clock = Clock(settings.time, self.start if terms.started is None else terms.started, view)
        self.criterion = criteria.get(settings.criterion)
        self.report = Report(settings)
        self.sampler = mi.load_dict({"type": "owen_sobol"})
        need = memory.need(view, settings, terms.features, terms.denoise, keeps=keeper is not None)
        largest_pass = memory.largest_pass(need, terms.memory_limit)
        self.drawer: Drawer = (
            Here(view, self.sampler, self.criterion.moments, largest_pass)
            if terms.drawer is None
            else terms.drawer(view, self.criterion, largest_pass)
        )
        self.total = settings.spp * view.pixel_count
        self.remembered: dict[str, Any] = {}
        self.complexity: pilot.Complexity | None = None
        remarks: list[str] = []
        self.wanted = wanted(view, settings, self.sampler.fork(), importance, remarks.append)
        self.state = State.beginning(self.drawer.empty(), settings)
        if keeper is not None:
            keeper.bind(view, settings, self.wanted)
            self.state = keeper.load(self.state, self.drawer.empty())
            self.state.plan_anew(self.total)
        self.state.meter.counted = (self.wanted > 0)[view.inner] if np.any(self.wanted == 0) else None
        self.report.rounds, self.report.notes = self.state.rounds, self.state.notes
        for remark in remarks:
            self.report.note(remark)
        self.leftover = Leftover(view, self.sampler, self.seed) if denoises else None
        self.left: NDArray[np.float64] | float = 1.0
        """Share of each pixel's noise that denoising is expected to leave."""
        self.noise: Noise | None = None
        self.course = Course(self.clock, self.total, view.pixel_count)

    @property
    def estimate(self) -> Estimate:
        """What is known of the picture."""
        return self.state.estimate

    @property
    def hold_out(self) -> bool:
        """Whether samples that decide are kept out of the picture."""
        return self.settings.unbiased and self.criterion.needs_radiance and not self.settings.too_small

    @property
    def loses_light(self) -> bool:
        """Whether samples that decide are in the picture, in such a way that the bias can be measured."""
        return self.criterion.needs_radiance and self.criterion.spends == "deviation" and not self.settings.unbiased

    @property
    def unbiased_so_far(self) -> bias.UnbiasedMean:
        """The unbiased mean of all rounds before the last."""
        return self.state.unbiased or bias.UnbiasedMean.nothing(self.view.grid, len(self.view.channels))

    @property
    def measures(self) -> bool:
        """Whether it is measured from round to round how noisy the picture is."""
        return self.settings.noise is not None or self.terms.denoise

    @property
    def seed(self) -> int:
        """Seed of the samples that are drawn now."""
        decides = self.hold_out and self.state.held_out is None
        return self.settings.seed ^ HELD_OUT_KEY if decides else self.settings.seed

    def run(self) -> Result:
        """Run all rounds, or those that are missing, and develop the picture."""
        try:
            self.run_rounds()
            return self.develop()
        except ClusterError as error:
            raise type(error)(f"{error} {self.what_is_kept()}") from None

    def what_is_kept(self) -> str:
        """Keep what there is, if that can be, after workers have failed; return a sentence about it."""
        if self.keeper is None:
            return "Nothing is kept: name a checkpoint to go on from."
        with suppress(ClusterError):  # sums that are lost: the sentence says how many the file has
            self.keeper.save(self.state)
        return self.keeper.in_words(self.progress().total)

    def run_rounds(self) -> None:
        """Run all rounds, or those that are missing."""
        growth = PRIORITY_GROWTH if self.criterion.spends == "priority" else GROWTH
        goals = round_goals(self.settings, self.criterion.needs_radiance, self.view.pixel_count, growth)
        if self.criterion.needs_radiance and len(goals) == 1:
            self.report.note(
                f"Uniform: {self.settings.spp} spp leave nothing to decide after a first look with "
                f"{self.settings.pilot_samples} samples per pixel; use a larger spp or set pilot_spp."
            )
        state = self.state
        if state.allocation is not None:
            self.draw_round()
        elif state.done and self.measures:
            self.measure_noise(anew=state.meter.image is None)
        while self.report.stopped_by is None:
            goal, self.report.stopped_by = next_goal(goals, state.done, self.settings, self.noise, self.clock)
            if goal is None:
                break
            self.begin_round(goal, last=goal == goals[-1])
            self.draw_round()

    def begin_round(self, goal: int, last: bool) -> None:
        """Decide who gets the samples of a round that ends with ``goal`` of them in all."""
        state = self.state
        learns = state.done > 0 and self.criterion.needs_radiance
        known = self.timed("seconds_statistics", self.estimate.statistics) if learns else None
        if self.hold_out and last and state.held_out is None:
            self.start_over()
        if state.held_out is not None:
            goal -= int(state.held_out_samples)
        if self.loses_light and known is not None:
            state.unbiased = self.unbiased_so_far.after(state.before, known)
        decision = self.decide(known, state.before, goal)
        state.before, state.allocation, state.chance = known, decision.allocation, decision.chance

    def start_over(self) -> None:
        """Put aside all samples drawn so far, and draw others from here on."""
        state = self.state
        state.held_out, state.estimate = self.estimate, self.drawer.empty()
        state.held_out_samples = state.done
        state.drawn = np.zeros(self.view.grid, np.uint32)
        self.report.note(
            f"Unbiased: {state.done // self.view.pixel_count} samples per pixel decided and are not in the picture."
        )

    def timed(self, name: str, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function and add its seconds to the field ``name`` of the report."""
        start = time.perf_counter()
        result = function(*arguments)
        setattr(self.report, name, getattr(self.report, name) + time.perf_counter() - start)
        return result

    def look(self) -> pilot.Complexity:
        """Trace the pilot rays, the first time."""
        self.state.looked = True
        if self.complexity is None:
            settings = self.settings
            # A sampler of its own: with what pilot rays leave in it, drawing would have to be traced twice.
            arguments = (self.view, self.sampler.fork(), settings.seed, settings.pilot_rays, settings.block)
            self.complexity = self.timed("seconds_pilot", pilot.measure_complexity, *arguments)
        return self.complexity

    def decide(self, known: Statistics | None, before: Statistics | None, goal: int) -> Decision:
        """Return how many samples each pixel is to have when ``goal`` are drawn."""
        start, looking = time.perf_counter(), self.report.seconds_pilot
        state, settings = self.state, self.settings
        teaches = self.hold_out and state.held_out is None
        total = goal if state.held_out is not None else self.total
        closed = not (settings.unbiased or settings.is_open)
        situation = Situation(state.drawn, goal, total, may_settle=closed, horizon=goal if settings.is_open else total)
        first = goal <= settings.pilot_samples * self.view.pixel_count and state.held_out is None
        if self.criterion.needs_radiance and (known is None or teaches or first):
            even = np.ones(self.view.grid) if goal < self.total else self.wanted
            return Decision(share_out(even, even, settings, situation, False, state.generator))
        if self.leftover is not None and known is not None and before is not None:
            self.left = self.timed("seconds_denoising", self.leftover.share, before, known)
            self.remembered.clear()  # it goes by other weights
        evidence = criteria.Evidence(
            look=self.look,
            statistics=known,
            before=before,
            weight=self.weight(known),
            weight_before=None if before is None else self.weight(before),
            colour_channels=self.view.colour_channels,
            wanted=self.wanted,
            memory=self.remembered,
        )
        with threads.for_files():  # a criterion may be anybody's
            decision = decide(self.criterion, evidence, settings, situation, state.generator)
        state.importance = None if decision.importance is None else relative(decision.importance)
        if decision.note:
            self.report.note(decision.note, once=decision.note.partition(" ")[0])
        self.report.seconds_deciding += time.perf_counter() - start - (self.report.seconds_pilot - looking)
        return decision

    def weight(self, known: Statistics | None) -> NDArray[np.float64]:
        """Return the objective's weight of each pixel (grid), up to a factor that all of them share.

        It is that of the mean, smoothed as the film's filter will smooth it.
        """
        if known is None:
            return np.ones(self.view.grid)
        brightness = self.view.luminance(known.mean)
        smooth = gaussian_filter(brightness, 1.0, mode="nearest")
        weights = objective.weights(self.settings.objective, smooth, self.settings.exposure)
        return objective.without_scale(weights) * self.left

    def draw_round(self) -> None:
        """Draw what the allocation has beyond what is drawn, pass by pass."""
        state, report = self.state, self.report
        allocation = state.allocation
        assert allocation is not None
        start = time.perf_counter()
        left = int((allocation - self.estimate.drawn()).sum())
        drawing = self.drawer.draw(self.estimate, state.drawn, allocation, self.seed, self.settings.spp**-0.5)
        with closing(drawing) as passes:
            for one in passes:
                left -= one.samples
                state.done += one.samples
                report.seconds_drawing += one.seconds_drawing
                report.seconds_statistics += one.seconds_adding
                if one.samples:
                    self.clock.passed(one.samples)
                if not self.go_on(finished=left == 0):
                    return
        samples = int((allocation - state.drawn).sum())
        state.drawn, state.allocation = allocation, None
        state.rounds.append(Round(samples, *extent(allocation), time.perf_counter() - start))
        if self.measures:
            self.measure_noise(anew=True)
        if self.settings.time is not None and len(state.rounds) == 1:
            self.rehearse()
        if self.keeper is not None:
            elsewhere = self.terms.drawer is not None  # sums that can be lost without this process
            self.keeper.save_if_due(state, at_once=elsewhere and self.keeper.writes == 0)

    def rehearse(self) -> None:
        """Develop the picture twice: that compiles what it needs, and then tells how much time to keep for the end."""
        self.timed("seconds_statistics", self.estimate.develop)
        start = time.perf_counter()
        self.timed("seconds_statistics", self.estimate.develop)
        pixels = self.view.pixel_count
        after = FEATURE_SECONDS * pixels * self.terms.features + DENOISE_SECONDS * pixels * self.terms.denoise
        self.clock.keep_back(time.perf_counter() - start + after)

    def measure_noise(self, anew: bool) -> None:
        """Find how noisy the picture is, ``anew`` if it has changed since that was last found."""
        image, stderr = self.timed("seconds_statistics", self.estimate.develop)
        count = self.estimate.samples()
        if anew:
            self.state.meter.follow(self.view, self.settings, image, stderr, count)
        self.noise = self.state.meter.look(self.view, self.settings, image, stderr)
        if self.settings.noise is not None:
            self.course.measured(self.noise, self.state.done)

    def go_on(self, finished: bool) -> bool:
        """Tell the caller of progress; return whether to continue with this round, or with what follows it."""
        state = self.state
        if self.keeper is not None and not finished:
            self.keeper.save_if_due(state)
        if self.tell(self.progress()) is False and state.done < self.total:
            self.report.stopped_by = "person"
        elif not finished and self.clock.is_over() and len(state.rounds) > 0:
            self.report.stopped_by = "time"
        return finished or self.report.stopped_by is None

    def tell(self, now: Progress) -> bool | None:
        """Call the progress callback, if there is one; it may read and write files."""
        if self.terms.progress is None:
            return None
        answer = None
        try:
            with threads.for_files():
                answer = self.terms.progress(now)
        except PendingWriteError as error:  # of a picture to look at meanwhile, which is not worth the render
            self.report.unwritten.append(str(error))
        return answer

    def progress(self) -> Progress:
        """Return how far the render is."""
        state, done = self.state, self.state.done
        ends_with = 0 if state.allocation is None else int(state.allocation.sum(dtype=np.int64))
        goal = max(done, state.held_out_samples + ends_with)
        noise = self.noise if self.settings.noise is not None else None
        return Progress(
            done=done,
            total=self.course.expected(done, goal),
            seconds=time.perf_counter() - self.start,
            remaining=self.course.seconds_left(done, goal),
            noise=noise.error if noise else None,
            converged=noise.converged if noise else None,
            fraction=self.course.fraction(done, goal),
            is_open=self.settings.is_open,
            develop=lambda: self.estimate.develop()[0],
            count=self.estimate.samples,
        )

    def tell_the_end(self, image: NDArray[np.float32], count: NDArray[np.uint32]) -> None:
        """Tell the caller of the picture as it is at the end."""
        now = replace(self.progress(), remaining=0.0, finished=True, develop=lambda: image, count=lambda: count)
        if self.report.complete:
            now = replace(now, total=now.done, fraction=1.0)
        self.tell(now)

    def develop(self) -> Result:
        """Return the picture and all that is known about it."""
        state, report = self.state, self.report
        if self.keeper is not None:
            self.keeper.save(state)
            report.unwritten += self.keeper.complaints
            report.notes = [*report.notes, *self.keeper.complaints]
        state.estimate = self.timed("seconds_statistics", state.estimate.here)
        if state.held_out is not None and (state.allocation is not None or not report.complete):
            state.estimate.merge(state.held_out.here())
            report.note("Not unbiased, as it was stopped: the samples that decided are in the picture.")
        image, stderr = self.timed("seconds_statistics", self.estimate.develop)
        statistics = self.estimate.statistics()
        if self.noise is not None:  # the last round may have been cut short
            self.noise = state.meter.look(self.view, self.settings, image, stderr)
        entropy = self.look().shape_entropy if state.looked else None
        drawn = self.view, self.sampler, self.settings.seed
        seen = self.timed("seconds_features", see, *drawn, statistics.count) if self.terms.features else None
        unbiased = state.unbiased_mean(statistics) if self.loses_light else None
        right = bias.with_lost_light(self.view, image, stderr, statistics, unbiased)
        report.light_given_back = bias.part_of(right - image, image, self.view.colour_channels)
        noisy = None
        if self.terms.denoise:
            noisy = right[..., : self.view.colour_channels]
            found = image, stderr, statistics, state.meter.scale
            clean = self.timed("seconds_denoising", without_noise, *drawn, *found)
            right = bias.with_lost_light(self.view, clean, stderr, statistics, unbiased)
        report.elsewhere = self.drawer.describe()
        report.describe(self.view, statistics, state.done, self.noise)
        if not self.view.scene.emitters() and not np.any(right[..., : self.view.colour_channels]):
            report.note("The picture is black, as the scene has no emitter: add a light, or something that shines.")
        inner = self.view.inner
        self.tell_the_end(right, statistics.count[inner])
        return Result(
            image=right,
            samples=statistics.count[inner],
            stderr=stderr,
            complexity=self.layer(entropy),
            importance=self.layer(state.importance),
            cost=statistics.rays[inner],
            noisy=noisy,
            seen=seen,
            channels=list(self.view.channels),
            window=self.view.window,
            seconds=time.perf_counter() - self.start,
            report=report,
        )

    def layer(self, values: NDArray | None) -> NDArray[np.float32]:
        """Return the part of ``values`` (grid) that is in the image; zeros if there are none."""
        return (np.zeros(self.view.grid) if values is None else values)[self.view.inner].astype(np.float32)


def extent(counts: NDArray[np.uint32]) -> tuple[int, int]:
    """Return the least and the most of some counts."""
    return int(counts.min()), int(counts.max())
