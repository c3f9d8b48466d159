"""Render the cells of a scene that are not there yet, one after the other, and keep each as it is made."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

from tracer.errors import TracerError
from tracer.loop import Progress
from tracer.study.cells import Cell, is_kept, store
from tracer.study.methods import Method, open_own, open_stock
from tracer.study.plan import Budget, MethodPlan, Plan, Scene
from tracer.study.results import Failure

WARM_UP_SPP = 12
"""Enough for a round that adapts, so that all kernels are compiled before anything is timed."""
FASTEST_GROWTH = 8
"""Most by which the next trial's samples exceed the last one's while the pace of a method is found."""
TRUSTED_SHARE = 0.2
"""Part of a budget in seconds that a trial must take for its pace to be trusted."""

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
                    failures.append(failure(cell, error))
                told(cell, f"{scene.name}: {cell.method}, {cell.budget.label}, seed {cell.seed}")
    return failures


def failure(cell: Cell, error: Exception) -> Failure:
    """Return the record of a cell that failed, in one line."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    message = lines[0] if lines else type(error).__name__
    if not isinstance(error, TracerError):
        message = f"{type(error).__name__}: {message}"
    return Failure(cell.scene, cell.method, cell.budget.label, cell.seed, message)


class Opened:
    """A method on a scene; it is opened, and its kernels compiled, when it is first needed."""

    def __init__(self, stack: ExitStack, scene: Scene, plan: MethodPlan, told: Told) -> None:
        self.stack, self.scene, self.plan, self.told = stack, scene, plan, told
        self.method: Method | None = None
        self.paces: dict[Budget, int] = {}
        self.broken: Exception | None = None
        """Why it could not be opened: its other cells need not try again."""

    def shoot(self, cell: Cell) -> tuple:
        """Return the picture of a cell and the samples per pixel that were asked for."""
        if self.broken is not None:
            raise self.broken
        try:
            method = self.ready()
        except Exception as error:
            self.broken = error
            raise
        spp = self.find_spp(method, cell.budget)
        return method(spp, cell.seed), spp

    def ready(self) -> Method:
        """Return the method, warm."""
        if self.method is None:
            if self.plan.criterion is None:
                method = open_stock(self.stack, self.scene.setting, self.plan.sampler)
            else:
                method = open_own(self.stack, self.scene.setting, self.passed, **self.plan.settings())
            least = max(self.plan.min_spp or 1, 2 * (self.plan.pilot_spp or 1))
            method(max(WARM_UP_SPP, least) if self.plan.max_spp is None else self.plan.max_spp, 0)
            self.method = method
        return self.method

    def passed(self, progress: Progress) -> None:
        """Let the person stop within a picture."""
        self.told(None, "")

    def find_spp(self, method: Method, budget: Budget) -> int:
        """Return the samples per pixel that a budget buys: trials grow until one takes a good part of the time."""
        if budget.kind == "spp":
            return int(budget.amount)
        if budget not in self.paces:
            for spp in self.trials(method, budget):
                self.paces[budget] = spp
        return self.paces[budget]

    def trials(self, method: Method, budget: Budget) -> Iterator[int]:
        """Yield ever better guesses of how many samples per pixel take the seconds of a budget."""
        spp = WARM_UP_SPP
        for trial in range(8):
            seconds = method(spp, trial).seconds
            pace = budget.amount / seconds
            yield max(1, round(spp * pace))
            if seconds >= TRUSTED_SHARE * budget.amount:
                return
            spp = max(1, round(spp * min(FASTEST_GROWTH, pace)))
