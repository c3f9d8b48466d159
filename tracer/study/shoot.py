"""Render the cells of a scene that are not there yet, one after the other, and keep each as it is made."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from tracer.errors import TracerError
from tracer.loop import Progress
from tracer.study.cells import Cell, is_kept, store
from tracer.study.methods import Method, Shot, open_own, open_stock
from tracer.study.plan import Budget, MethodPlan, Plan, Scene
from tracer.study.results import Failure

WARM_UP_SPP = 12
"""Enough for a round that adapts, so that all kernels of ours are compiled before anything is timed."""
FASTEST_GROWTH = 8
"""Most by which the next trial's samples exceed the last one's while the pace of a method is found."""
TRIALS = 8
TRUSTED = 0.15
"""Two times that differ by less than this part are the same."""
MOST_REPEATS = 3

Told = Callable[[Cell | None, str], None]
"""Called with the cell that is done, or None while one is under way, and what to say. Raises KeyboardInterrupt."""


def shoot(plan: Plan, scene: Scene, blocks: list[list[Cell]], output: Path, run: str, told: Told) -> list[Failure]:
    """Render what is missing; return what could not be rendered.

    Within a block all methods follow one another, so that a machine that changes speed does so for all of them.
    """
    missing = [[cell for cell in block if not is_kept(cell, output)] for block in blocks]
    needed = {cell.method for block in missing for cell in block}
    failures: list[Failure] = []
    with ExitStack() as stack:
        opened: dict[str, Opened] = {}
        for method in plan.methods:
            if method.name in needed:
                opened[method.name] = Opened(stack, scene, method, told)
        for block in missing:
            for cell in block:
                told(None, f"{scene.name}: {cell.method}, {cell.budget.label}, seed {cell.seed}")
                try:
                    shot, spp = opened[cell.method].shoot(cell)
                    store(cell, output, shot, spp, run)
                except Exception as error:  # whatever it is, the other cells can still be measured
                    failures.append(failure(cell.scene, cell.method, cell.budget.label, cell.seed, error))
                told(cell, f"{scene.name}: {cell.method}, {cell.budget.label}, seed {cell.seed}")
    return failures


def failure(scene: str, method: str, budget: str, seed: int, error: Exception) -> Failure:
    """Return the record of something that failed, with why in one line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    message = lines[0] if lines else type(error).__name__
    if not isinstance(error, TracerError):
        message = f"{type(error).__name__}: {message}"
    return Failure(scene, method, budget, seed, message)


class Opened:
    """A method on a scene; it is opened, and its kernels compiled, when it is first needed."""

    def __init__(self, stack: ExitStack, scene: Scene, plan: MethodPlan, told: Told) -> None:
        self.stack, self.scene, self.plan, self.told = stack, scene, plan, told
        self.method: Method | None = None
        self.warm: set[int] = set()
        """Samples per pixel for which kernels are compiled."""
        self.paces: dict[Budget, int] = {}
        self.broken: Exception | None = None
        """Why it could not be opened: its other cells need not try again."""

    def shoot(self, cell: Cell) -> tuple[Shot, int]:
        """Return the picture of a cell and the samples per pixel that were asked for."""
        if self.broken is not None:
            raise self.broken
        try:
            method = self.ready()
        except Exception as error:
            self.broken = error
            raise
        spp = self.find_spp(method, cell.budget)
        self.warm_up(method, spp)
        return method(spp, cell.seed), spp

    def ready(self) -> Method:
        """Return the method, opened."""
        if self.method is None:
            if self.plan.criterion is None:
                self.method = open_stock(self.stack, self.scene.setting, self.plan.sampler)
            else:
                self.method = open_own(self.stack, self.scene.setting, self.passed, **self.plan.settings())
        return self.method

    def passed(self, progress: Progress) -> None:
        """Let the person stop within a picture."""
        self.told(None, "")

    def warm_up(self, method: Method, spp: int) -> None:
        """Compile the kernels: Mitsuba's samplers need others for every count, ours the same for all."""
        if self.plan.criterion is not None:
            if self.warm:
                return
            least = max(self.plan.min_spp or 1, 2 * (self.plan.pilot_spp or 1), WARM_UP_SPP)
            spp = min(spp, least)
        if spp not in self.warm:
            steady_seconds(method, spp)
            self.warm.add(spp)

    def find_spp(self, method: Method, budget: Budget) -> int:
        """Return the samples per pixel that a budget buys: trials go on until one takes about as long."""
        if budget.kind == "spp":
            return int(budget.amount)
        if budget not in self.paces:
            spp = max(self.plan.min_spp or 1, WARM_UP_SPP)
            for _ in range(TRIALS):
                pace = budget.amount / steady_seconds(method, spp)
                spp = max(1, round(spp * min(pace, FASTEST_GROWTH)))
                if abs(pace - 1) < TRUSTED:
                    break
            self.paces[budget] = spp
        return self.paces[budget]


def steady_seconds(method: Method, spp: int) -> float:
    """Return how long a picture takes when nothing is compiled any more: until two in a row take about as long."""
    seconds = method(spp, 0).seconds
    for _ in range(MOST_REPEATS):
        before, seconds = seconds, method(spp, 0).seconds
        if seconds > (1 - TRUSTED) * before:
            break
    return seconds
