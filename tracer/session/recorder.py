"""Where the seconds of a render go."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from tracer.core import stopwatch
from tracer.core.arrays import Counts
from tracer.core.stopwatch import NO_TIME, Seconds
from tracer.report import Report, Round
from tracer.session.local_drawer import Pass
from tracer.session.state import State


class Recorder:
    """Adds to a report what each part of a render took; every second is counted once."""

    def __init__(self, report: Report) -> None:
        self.report = report
        self.start = stopwatch.read().wall
        self.taken: dict[str, Seconds] = {}
        """What each part took, by the name of its field in the report, with the seconds of the processor."""
        self.inner = [NO_TIME]
        """What blocks within each block under way have taken, outermost first."""

    @property
    def seconds(self) -> float:
        """Seconds since the start."""
        return stopwatch.read().wall - self.start

    def begin(self, state: State, remarks: list[str]) -> None:
        """Let the report show the rounds and notes of a state, and remarks made before there was one."""
        self.report.rounds, self.report.notes = state.rounds, state.notes
        for remark in remarks:
            self.report.note(remark)

    @contextmanager
    def timing(self, name: str) -> Iterator[None]:
        """Add the seconds of a block to the field ``name`` of the report, but for those of timed blocks within it."""
        start = stopwatch.read()
        self.inner.append(NO_TIME)
        try:
            yield
        finally:
            taken = stopwatch.read() - start
            self.add(name, taken - self.inner.pop())
            self.inner[-1] += taken

    def add(self, name: str, seconds: Seconds) -> None:
        """Add seconds to the field ``name`` of the report."""
        setattr(self.report, name, getattr(self.report, name) + seconds.wall)
        self.taken[name] = self.taken.get(name, NO_TIME) + seconds

    def add_pass(self, drawn: Pass) -> None:
        """Take in what a pass took."""
        self.add("seconds_drawing", drawn.drawing)
        self.add("seconds_adding", drawn.adding)

    def add_round(self, state: State, allocation: Counts, seconds: float) -> None:
        """Take in a round that is complete; ``allocation``: samples of each pixel after it."""
        samples = int((allocation - state.drawn).sum())
        state.rounds.append(Round(samples, int(allocation.min()), int(allocation.max()), seconds))
