"""Where the seconds of a render go."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from tracer.core.arrays import Counts
from tracer.result import Report, Round
from tracer.session.local_drawer import Pass
from tracer.session.state import State


class Recorder:
    """Adds to a report what each part of a render took; every second is counted once."""

    def __init__(self, report: Report) -> None:
        self.report = report
        self.start = time.perf_counter()
        self.inner = [0.0]
        """Seconds that blocks within each block under way have taken, outermost first."""

    @property
    def seconds(self) -> float:
        """Seconds since the start."""
        return time.perf_counter() - self.start

    def begin(self, state: State, remarks: list[str]) -> None:
        """Let the report show the rounds and notes of a state, and remarks made before there was one."""
        self.report.rounds, self.report.notes = state.rounds, state.notes
        for remark in remarks:
            self.report.note(remark)

    @contextmanager
    def timing(self, name: str) -> Iterator[None]:
        """Add the seconds of a block to the field ``name`` of the report, but for those of timed blocks within it."""
        start = time.perf_counter()
        self.inner.append(0.0)
        try:
            yield
        finally:
            taken = time.perf_counter() - start
            self.add(name, taken - self.inner.pop())
            self.inner[-1] += taken

    def add(self, name: str, seconds: float) -> None:
        """Add seconds to the field ``name`` of the report."""
        setattr(self.report, name, getattr(self.report, name) + seconds)

    def add_pass(self, drawn: Pass) -> None:
        """Take in what a pass took."""
        self.add("seconds_drawing", drawn.seconds_drawing)
        self.add("seconds_statistics", drawn.seconds_adding)

    def add_round(self, state: State, allocation: Counts, seconds: float) -> None:
        """Take in a round that is complete; ``allocation``: samples of each pixel after it."""
        samples = int((allocation - state.drawn).sum())
        state.rounds.append(Round(samples, int(allocation.min()), int(allocation.max()), seconds))
