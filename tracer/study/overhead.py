"""What adaptivity costs: seconds beside those of ``mi.render``, and the share of them in which nothing is drawn."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import stats

from tracer.loop import render_view
from tracer.result import Result
from tracer.scene import View, open_scene
from tracer.settings import make_settings
from tracer.source import load
from tracer.study.compare import Interval, interval, stock_method
from tracer.study.record import markdown_table
from tracer.study.run import StepCallback, scene_name
from tracer.study.table import bounds


@dataclass(frozen=True)
class Timing:
    """Seconds of one scene by four ways to render it, one entry a repetition."""

    scene: str
    independent: list[float]
    """``mi.render`` with Mitsuba's sampler of that name."""
    owen_sobol: list[float]
    """``mi.render`` with our sampler."""
    uniform: list[float]
    """Our loop and estimate with a constant map."""
    fused: list[float]
    """Our loop with the map that it decides on itself."""
    idle: list[float]
    """Share of ``fused`` in which no samples are drawn: pilot, statistics, decisions, the picture."""

    @property
    def sampler_throughput(self) -> Interval:
        """Samples per second of ``mi.render`` with our sampler over those with ``independent``."""
        return interval([a / b for a, b in zip(self.independent, self.owen_sobol, strict=True)])

    @property
    def uniform_throughput(self) -> Interval:
        """Samples per second of the constant map over those of ``mi.render`` with the same sampler."""
        return interval([a / b for a, b in zip(self.owen_sobol, self.uniform, strict=True)])

    @property
    def idle_share(self) -> Interval:
        """Mean of ``idle``, with its interval over repetitions (Student's t)."""
        mean, spread = float(np.mean(self.idle)), float(stats.sem(self.idle))
        half = float(stats.t.ppf(0.975, len(self.idle) - 1)) * spread
        return Interval(mean, max(mean - half, 0.0), min(mean + half, 1.0))


def measure(
    scene: Path, side: int, spps: Sequence[int], repetitions: int, progress: StepCallback | None = None
) -> list[Timing]:
    """Time a scene at ``side`` x ``side`` pixels and the first of ``spps``.

    The four ways take turns, so that a machine that changes speed does so for all of them; the first turn compiles and
    is not counted. Raises KeyboardInterrupt if ``progress`` stops it.
    """
    spp = spps[0]
    name = scene_name(scene)
    timing = Timing(name, [], [], [], [], [])
    with ExitStack() as stack:

        def opened(sampler: str, merge_meshes: bool) -> View:
            source = load(scene, sampler=sampler, merge_meshes=merge_meshes)
            return stack.enter_context(open_scene(source, size=(side, side)))

        view = opened("owen_sobol", False)

        def own(criterion: str) -> Callable[[int], Result]:
            return lambda seed: render_view(view, make_settings(spp=spp, seed=seed, criterion=criterion))

        def stock(sampler: str) -> Callable[[int], object]:
            method = stock_method(opened(sampler, True))
            return lambda seed: method(spp, seed)

        ways: dict[str, Callable[[int], object]] = {
            "independent": stock("independent"),
            "owen_sobol": stock("owen_sobol"),
            "uniform": own("uniform"),
            "fused": own("fused"),
        }
        for repetition in range(repetitions + 1):
            for count, (way, render) in enumerate(ways.items()):
                start = time.perf_counter()
                result = render(repetition)
                seconds = time.perf_counter() - start
                if repetition > 0:
                    getattr(timing, way).append(seconds)
                    if way == "fused" and isinstance(result, Result):
                        timing.idle.append(1.0 - result.report.seconds_drawing / seconds)
                done = repetition * len(ways) + count + 1
                if progress and progress(f"{name}: {way}", done, (repetitions + 1) * len(ways)) is False:
                    raise KeyboardInterrupt
    return [timing]


HEADINGS = (
    "scene",
    "mi.render, independent",
    "mi.render, owen_sobol",
    "constant map",
    "fused",
    "throughput: owen_sobol / independent",
    "throughput: constant map / mi.render",
    "fused: share not drawing",
)


def markdown(timings: Sequence[Timing]) -> str:
    """Return the table, times in seconds (geometric means)."""
    lines = []
    for timing in timings:
        seconds = [timing.independent, timing.owen_sobol, timing.uniform, timing.fused]
        ratios = [timing.sampler_throughput, timing.uniform_throughput, timing.idle_share]
        lines.append([timing.scene, *(f"{interval(s).mean:.2f}" for s in seconds), *(bounds(r, 3) for r in ratios)])
    return markdown_table(HEADINGS, lines)
