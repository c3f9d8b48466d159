"""The loop: look, decide, draw, and again with what was learned."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from tracer import backend, criteria, draw, objective, pilot
from tracer.decide import Decision, Situation, decide, share_out
from tracer.estimate import Estimate, Statistics
from tracer.result import Report, Result, Round, empty_pixels
from tracer.rounds import GROWTH, PASS_SIZES, PRIORITY_GROWTH, even_pass, next_pass_size, round_goals
from tracer.scene import Size, View, open_scene
from tracer.settings import Settings, make_settings
from tracer.wanted import wanted


@dataclass(frozen=True)
class Progress:
    """What a progress callback is told after every pass."""

    done: int
    """Samples drawn."""
    total: int
    """Samples of the whole budget."""
    seconds: float
    """Since the start."""


HELD_OUT_KEY = 0x5EED0
"""Keeps samples that only decide apart from those that make the picture."""

ProgressCallback = Callable[[Progress], bool | None]
"""Called after every pass; return False to stop with what there is."""


def render(
    scene: Any,
    *,
    integrator: Any = None,
    sensor: int = 0,
    size: Size = None,
    progress: ProgressCallback | None = None,
    importance: Any = None,
    **settings: Any,
) -> Result:
    """Render ``scene`` (path of an XML file, dictionary, or ``mi.Scene``) and return picture, counts and errors.

    ``importance``: array (H, W) or image file whose values multiply the importance of each pixel. Further keywords are
    those of ``tracer.settings.Settings``: spp, seed, criterion, objective, exposure, pilot_spp, min_spp, max_spp, cost,
    block, unbiased, shape_weights; where the scene's integrator is ``adaptive``, its parameters are the defaults. Sets
    the Mitsuba variant ``llvm_ad_rgb`` unless one is active. Raises the errors of ``tracer.errors``.
    """
    backend.activate()
    if isinstance(importance, str | Path):
        settings["importance"], importance = str(importance), None
    with open_scene(scene, sensor, integrator, size) as view:
        return render_view(view, make_settings(**{**view.settings, **settings}), progress, importance)


def render_view(
    view: View, settings: Settings, progress: ProgressCallback | None = None, importance: Any = None
) -> Result:
    """Render an open scene; see ``render``."""
    with dr.suspend_grad():
        rendering = Rendering(view, settings, progress, importance)
        try:
            return rendering.run()
        finally:
            rendering.draw.close()


class Rendering:
    """One render under way."""

    def __init__(
        self, view: View, settings: Settings, progress: ProgressCallback | None = None, importance: Any = None
    ) -> None:
        self.start = time.perf_counter()
        self.view, self.settings, self.progress = view, settings, progress
        self.criterion = criteria.get(settings.criterion)
        self.report = Report(settings)
        self.sampler = mi.load_dict({"type": "owen_sobol"})
        self.draw = draw.Recorded(view, self.sampler, self.criterion.moments)
        self.kinds = draw.moment_counts(view, self.criterion.moments)
        self.estimate = Estimate(view, *self.kinds)
        self.generator = np.random.default_rng(np.random.SeedSequence([settings.seed, 1]))
        self.total = settings.spp * view.pixel_count
        self.drawn = np.zeros(view.grid, np.uint32)
        self.memory: dict[str, Any] = {}
        self.complexity: pilot.Complexity | None = None
        self.wanted = wanted(view, settings, self.sampler.fork(), importance)
        self.done = 0
        self.seed = settings.seed
        self.held_out: Estimate | None = None
        """Samples that decided and are kept out of the picture."""
        self.pass_size = PASS_SIZES[1]

    def run(self) -> Result:
        """Run all rounds and develop the picture."""
        growth = PRIORITY_GROWTH if self.criterion.spends == "priority" else GROWTH
        goals = round_goals(self.settings, self.criterion.needs_radiance, self.view.pixel_count, growth)
        if self.criterion.needs_radiance and len(goals) == 1:
            self.report.notes.append(
                f"Uniform: {self.settings.spp} spp leave nothing to decide after a first look with "
                f"{self.settings.pilot_samples} samples per pixel; use a larger spp or set pilot_spp."
            )
        hold_out = self.settings.unbiased and self.criterion.needs_radiance and len(goals) > 1
        if hold_out:
            self.seed ^= HELD_OUT_KEY
        before: Statistics | None = None
        known: Statistics | None = None
        for goal in goals:
            last = goal == goals[-1]
            if hold_out and last:
                self.start_over()
                goal -= self.done
            decision = self.decide(known, before, goal)
            self.draw_round(decision.allocation)
            if not self.report.complete or decision.settled:
                break
            if self.criterion.needs_radiance and not last:
                before, known = known, self.timed("seconds_statistics", self.estimate.statistics)
        return self.develop()

    def start_over(self) -> None:
        """Put aside all samples drawn so far, and draw others from here on."""
        self.seed ^= HELD_OUT_KEY
        self.held_out, self.estimate = self.estimate, Estimate(self.view, *self.kinds)
        self.drawn = np.zeros(self.view.grid, np.uint32)
        self.report.notes.append(
            f"Unbiased: {self.done // self.view.pixel_count} samples per pixel decided and are not in the picture."
        )

    def timed(self, name: str, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function and add its seconds to the field ``name`` of the report."""
        start = time.perf_counter()
        result = function(*arguments)
        setattr(self.report, name, getattr(self.report, name) + time.perf_counter() - start)
        return result

    def look(self) -> pilot.Complexity:
        """Trace the pilot rays, the first time."""
        if self.complexity is None:
            settings = self.settings
            # A sampler of its own: with what pilot rays leave in it, drawing would have to be traced twice.
            arguments = (self.view, self.sampler.fork(), settings.seed, settings.pilot_rays, settings.block)
            self.complexity = self.timed("seconds_pilot", pilot.measure_complexity, *arguments)
        return self.complexity

    def decide(self, known: Statistics | None, before: Statistics | None, goal: int) -> Decision:
        """Return how many samples each pixel is to have when ``goal`` are drawn."""
        start, looking = time.perf_counter(), self.report.seconds_pilot
        teaches = self.settings.unbiased and self.held_out is None and goal != self.total
        total = goal if self.held_out is not None else self.total
        situation = Situation(self.drawn, goal, total, may_settle=not self.settings.unbiased)
        if self.criterion.needs_radiance and (known is None or teaches):
            even = np.ones(self.view.grid) if goal < self.total else self.wanted
            return Decision(share_out(even, even, self.settings, situation, False, self.generator))
        evidence = criteria.Evidence(
            look=self.look,
            statistics=known,
            before=before,
            weight=self.weight(known),
            weight_before=None if before is None else self.weight(before),
            colour_channels=self.view.colour_channels,
            wanted=self.wanted,
            memory=self.memory,
        )
        decision = decide(self.criterion, evidence, self.settings, situation, self.generator)
        if decision.note:
            self.report.notes.append(decision.note)
        self.report.seconds_deciding += time.perf_counter() - start - (self.report.seconds_pilot - looking)
        return decision

    def weight(self, known: Statistics | None) -> NDArray[np.float64]:
        """Return the objective's weight of each pixel, from a mean smoothed as the film's filter will smooth it."""
        if known is None:
            return np.ones(self.view.grid)
        brightness = self.view.luminance(known.mean)
        smooth = gaussian_filter(brightness, 1.0, mode="nearest")
        return objective.weights(self.settings.objective, smooth, self.settings.exposure)

    def draw_round(self, allocation: NDArray[np.uint32]) -> None:
        """Draw what ``allocation`` has beyond what is drawn, pass by pass."""
        start = time.perf_counter()
        counts = allocation - self.drawn
        seed = dr.opaque(mi.UInt32, self.seed)
        scale = dr.opaque(mi.Float, self.settings.spp**-0.5)
        line = draw.Line(counts.ravel(), self.drawn.ravel())
        while line.taken < line.total:
            window = line.take(even_pass(line.total - line.taken, self.pass_size))
            pass_start = time.perf_counter()
            pixel, index = draw.lane_pixels(window)
            samples = self.draw(seed, pixel, index, scale)
            dr.sync_thread()
            pass_seconds = time.perf_counter() - pass_start
            self.report.seconds_drawing += pass_seconds
            self.pass_size = next_pass_size(window.sample_count / pass_seconds)
            self.timed("seconds_statistics", self.add, window, samples)
            if not self.go_on(window.sample_count):
                break
        self.drawn = allocation
        seconds = time.perf_counter() - start
        self.report.rounds.append(Round(int(counts.sum()), int(allocation.min()), int(allocation.max()), seconds))

    def add(self, window: draw.Window, samples: draw.Samples) -> None:
        """Add a pass to the estimate and wait for it."""
        self.estimate.add(window, samples)
        dr.sync_thread()

    def go_on(self, drawn: int) -> bool:
        """Tell the caller of progress; return whether to continue."""
        self.done += drawn
        if self.progress is None:
            return True
        if self.progress(Progress(self.done, self.total, time.perf_counter() - self.start)) is not False:
            return True
        self.report.complete = self.done >= self.total
        return False

    def develop(self) -> Result:
        """Return the picture and all that is known about it."""
        if self.held_out is not None and not self.report.complete:
            self.estimate.merge(self.held_out)
            self.report.notes.append("Not unbiased, as it was stopped: the samples that decided are in the picture.")
        image, stderr = self.timed("seconds_statistics", self.estimate.develop)
        statistics = self.estimate.statistics()
        invalid = int(statistics.invalid.sum())
        if invalid:
            self.report.notes.append(
                f"{invalid} samples in {np.count_nonzero(statistics.invalid)} pixels were not finite and are left out"
                f"{empty_pixels(((statistics.count == 0) & (statistics.invalid > 0))[self.view.inner])}."
            )
        if not self.report.complete:
            self.report.notes.append(f"Stopped after {self.done} of {self.total} samples.")
        inner = self.view.inner
        entropy = np.zeros(self.view.grid) if self.complexity is None else self.complexity.shape_entropy
        return Result(
            image=image,
            samples=statistics.count[inner],
            stderr=stderr,
            complexity=entropy[inner].astype(np.float32),
            channels=list(self.view.channels),
            seconds=time.perf_counter() - self.start,
            report=self.report,
        )
