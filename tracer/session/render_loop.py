"""The loop: look, decide, draw, and again with what was learned."""

from __future__ import annotations

import time
from contextlib import closing, suppress
from dataclasses import dataclass

from tracer.adaptive.schedule import Schedule
from tracer.errors import ClusterError
from tracer.scene.view import View
from tracer.session.keeper import Keeper
from tracer.session.local_drawer import Drawer
from tracer.session.planner import Planner
from tracer.session.progress_reporter import ProgressReporter
from tracer.session.recorder import Recorder
from tracer.session.state import State


@dataclass
class Rendering:
    """One render under way."""

    view: View
    state: State
    """What is drawn and known so far."""
    planner: Planner
    """Decides who gets samples."""
    drawer: Drawer
    """Draws them."""
    schedule: Schedule
    """Says when to stop."""
    keeper: Keeper | None
    """Keeps the state in a checkpoint, if there is to be one."""
    reporter: ProgressReporter
    """Tells the caller how far the render is."""
    recorder: Recorder
    """Notes where the seconds go."""

    def run(self) -> None:
        """Draw round after round, or those that are missing, until there is a reason to stop."""
        self.go_on_from_checkpoint()
        while (goal := self.schedule.next_goal(self.state.done)) is not None:
            self.planner.plan(self.state, self.schedule, goal, self.drawer.empty)
            self.draw_round()

    def go_on_from_checkpoint(self) -> None:
        """Finish the round that was under way, or measure what is there already."""
        if self.state.allocation is not None:
            self.draw_round()
        elif self.state.done and self.schedule.measures_noise:
            self.measure_noise(anew=self.state.meter.image is None)

    def draw_round(self) -> None:
        """Draw what the allocation has beyond what is drawn, pass by pass, until there is a reason to stop."""
        state, allocation, start = self.state, self.state.allocation, time.perf_counter()
        assert allocation is not None
        missing = int((allocation - state.estimate.drawn()).sum())
        seed, scale = self.planner.seed(state), self.planner.settings.spp**-0.5
        with closing(self.drawer.draw(state.estimate, state.drawn, allocation, seed, scale)) as passes:
            for drawn in passes:
                missing -= drawn.samples
                state.done += drawn.samples
                self.recorder.add_pass(drawn)
                if drawn.samples:
                    self.schedule.clock.passed(drawn.samples)
                if not self.keep_and_tell(finished=missing == 0):
                    return
        self.recorder.add_round(state, allocation, time.perf_counter() - start)
        state.drawn, state.allocation = allocation, None
        self.end_round()

    def keep_and_tell(self, finished: bool) -> bool:
        """Keep and tell what there is after a pass; return whether to continue with this round, or what follows it."""
        state, schedule = self.state, self.schedule
        if self.keeper is not None and not finished:
            self.keeper.save_if_due(state)
        if self.reporter.tell(state) is False and state.done < schedule.budget:
            schedule.stop("person")
        elif not finished and schedule.clock.is_over() and len(state.rounds) > 0:
            schedule.stop("time")
        return finished or schedule.stopped_by is None

    def end_round(self) -> None:
        """Learn from a whole round how noisy the picture is and how long its end will take, and keep it."""
        if self.schedule.measures_noise:
            self.measure_noise(anew=True)
        if self.schedule.settings.time is not None and len(self.state.rounds) == 1:
            self.rehearse()
        if self.keeper is not None:
            self.keeper.save_after_round(self.state)

    def measure_noise(self, anew: bool) -> None:
        """Find how noisy the picture is, ``anew`` if it has changed since that was last found."""
        state, settings = self.state, self.schedule.settings
        with self.recorder.timing("seconds_developing"):
            image, stderr = state.estimate.develop()
        if anew:
            state.meter.follow(self.view, settings, image, stderr, state.estimate.samples())
        self.schedule.noise = state.meter.look(self.view, settings, image, stderr)
        self.reporter.measured(self.schedule.noise, state.done)

    def rehearse(self) -> None:
        """Develop the picture twice: that compiles what it needs, and then tells how much time to keep for the end."""
        with self.recorder.timing("seconds_developing"):
            self.state.estimate.develop()
            start = time.perf_counter()
            self.state.estimate.develop()
        self.schedule.clock.keep_back(time.perf_counter() - start)

    def what_is_kept(self) -> str:
        """Keep what there is, if that can be, after workers have failed; return a sentence about it."""
        if self.keeper is None:
            return "Nothing is kept: name a checkpoint to go on from."
        with suppress(ClusterError):  # sums that are lost: the sentence says how many the file has
            self.keeper.save(self.state)
        return self.keeper.in_words(self.reporter.progress(self.state).total)
