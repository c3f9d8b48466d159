"""Tell a caller how far a render is."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tracer.adaptive.convergence import Noise
from tracer.adaptive.schedule import Schedule
from tracer.core import threads
from tracer.core.arrays import Counts, Singles
from tracer.errors import PendingWriteError
from tracer.progress import Course, Progress, ProgressCallback
from tracer.session.recorder import Recorder
from tracer.session.state import State


class ProgressReporter:
    """Calls a progress callback after every pass, and at the end."""

    def __init__(self, callback: ProgressCallback | None, schedule: Schedule, recorder: Recorder) -> None:
        self.callback, self.schedule, self.recorder = callback, schedule, recorder
        self.course = Course(schedule.clock, schedule.budget, schedule.pixel_count)

    def measured(self, noise: Noise, done: int) -> None:
        """Take in how noisy the picture is after ``done`` samples."""
        if self.schedule.settings.noise is not None:
            self.course.measured(noise, done)

    def tell(self, state: State) -> bool | None:
        """Call the callback, if there is one, and return what it answers."""
        return self.call(self.progress(state))

    def tell_the_end(self, state: State, image: Singles, count: Counts) -> None:
        """Call the callback with the picture (H, W, C) and the samples (H, W) of the result."""
        now = replace(self.progress(state), remaining=0.0, finished=True, develop=lambda: image, count=lambda: count)
        if self.recorder.report.complete:
            now = replace(now, total=now.done, fraction=1.0)
        self.call(now)

    def call(self, now: Progress) -> bool | None:
        """Call the callback, which may read and write files."""
        if self.callback is None:
            return None
        answer: Any = None
        try:
            with threads.for_files():
                answer = self.callback(now)
        except PendingWriteError as error:  # of a picture to look at meanwhile, which is not worth the render
            self.recorder.report.unwritten.append(str(error))
        return answer

    def progress(self, state: State) -> Progress:
        """Return how far the render is."""
        ends_with = 0 if state.allocation is None else int(state.allocation.sum(dtype=np.int64))
        goal = max(state.done, state.held_out_samples + ends_with)
        settings = self.schedule.settings
        noise = self.schedule.noise if settings.noise is not None else None
        return Progress(
            done=state.done,
            total=self.course.expected(state.done, goal),
            seconds=self.recorder.seconds,
            remaining=self.course.seconds_left(state.done, goal),
            noise=noise.error if noise else None,
            converged=noise.converged if noise else None,
            fraction=self.course.fraction(state.done, goal),
            is_open=settings.is_open,
            develop=lambda: state.estimate.develop()[0],
            count=lambda: state.estimate.samples(),
        )
