"""Draw the samples of a round in this process, pass by pass."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Protocol

import drjit as dr
import mitsuba as mi

from tracer.core import stopwatch
from tracer.core.arrays import Counts
from tracer.core.stopwatch import NO_TIME, Seconds
from tracer.criteria import Criterion
from tracer.film.estimate import Estimate
from tracer.sampling import samples
from tracer.sampling.passes import PASS_SIZES, even_pass, next_pass_size
from tracer.sampling.wavefront import Line, Stretch, lane_pixels
from tracer.scene.view import View
from tracer.session.recordings import recorded_drawing


@dataclass(frozen=True)
class Pass:
    """Samples that were drawn and added to an estimate, and how long that took."""

    samples: int
    drawing: Seconds = NO_TIME
    adding: Seconds = NO_TIME


class Drawer(Protocol):
    """Draws the samples of a render, in this process or elsewhere. Whoever it is, the sums are the same."""

    def empty(self) -> Estimate:
        """Return an estimate without samples, to add to."""

    def draw(
        self, estimate: Any, before: Counts, after: Counts, seed: int, scale: float
    ) -> Generator[Pass, None, None]:
        """Add to ``estimate`` what it lacks to have ``after`` (grid) samples, and tell of each pass.

        ``before`` (grid): samples there were before the round. ``scale``: of ray differentials. Left early, each pixel
        has some of its samples, the first ones. A pass without samples is a sign of life.
        """

    def describe(self) -> dict[str, Any]:
        """Return what drawing elsewhere took, as plain values."""

    def close(self) -> None:
        """Let go of what drawing needs."""


DrawerFor = Callable[[View, Criterion, int], Drawer]
"""From a view, the criterion that decides and the most samples of a pass to who draws."""


class LocalDrawer:
    """Draws in this process."""

    def __init__(
        self,
        view: View,
        moments: samples.Moments | None,
        largest_pass: int = PASS_SIZES[-1],
        keep: bool = False,
    ) -> None:
        """``keep``: whether the next render of the scene may use what is recorded in this one."""
        self.view = view
        self.kinds = samples.moment_counts(view, moments)
        self.stack = ExitStack()
        self.record = self.stack.enter_context(recorded_drawing(view, moments, keep))
        self.pass_size, self.largest_pass = next_pass_size(None, view.object_count), largest_pass

    def empty(self) -> Estimate:
        """Return an estimate of the view without samples."""
        return Estimate(self.view, *self.kinds)

    def draw(
        self, estimate: Estimate, before: Counts, after: Counts, seed: int, scale: float
    ) -> Generator[Pass, None, None]:
        """See ``Drawer``."""
        line = Line(Stretch(0, before.ravel(), after.ravel()), estimate.drawn().ravel())
        return self.draw_line(estimate, line, seed, scale)

    def draw_line(
        self, estimate: Estimate, line: Line, seed: int, scale: float, first_pixel: int = 0
    ) -> Generator[Pass, None, None]:
        """Draw a line; ``first_pixel``: of the view, for which the first one of ``estimate`` stands."""
        on_device = dr.opaque(mi.UInt32, seed), dr.opaque(mi.Float, scale)
        while line.taken < line.total:
            start = stopwatch.read()
            window = line.take(even_pass(line.total - line.taken, self.pass_size, self.largest_pass))
            pixel, index = lane_pixels(window, first_pixel)
            drawn = self.record(on_device[0], pixel, index, on_device[1])
            dr.sync_thread()
            drawing = stopwatch.read() - start
            self.pass_size = next_pass_size(window.lane_count / drawing.wall, self.view.object_count)
            estimate.add(window, drawn)
            dr.sync_thread()
            yield Pass(window.sample_count, drawing, stopwatch.read() - start - drawing)

    def describe(self) -> dict[str, Any]:
        """Return nothing: it is all here."""
        return {}

    def close(self) -> None:
        """Let go of scene and kernels, or keep them for the next render of the scene."""
        self.stack.close()
