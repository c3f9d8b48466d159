"""Render cells of a scene, one after the other, and keep each picture as soon as it is made."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from functools import cache
from pathlib import Path

from tracer.errors import TracerError
from tracer.progress import Progress
from tracer.study import oracle
from tracer.study.cells import Cell, store
from tracer.study.methods import Foretold, Method, Setting, Studio, TimedPicture
from tracer.study.oracle_measurements import measure_truth
from tracer.study.plan import Budget, MethodPlan, Plan, Scene
from tracer.study.records import Failure

WARM_UP_SPP = 40
"""Samples per pixel of a warm-up: enough for an adaptive round, unbiased or not, so that our kernels are compiled."""
FASTEST_GROWTH = 8
"""Largest factor from the samples of a trial to those of the next, while the pace of a method is measured."""
TRIALS = 8
"""Most trials to find the samples per pixel that a budget in seconds buys."""
TRUSTED = 0.15
"""Relative difference below which two times count as equal."""
MOST_REPEATS = 3
"""Most times that a picture is repeated until its time is steady."""

CellCallback = Callable[[Cell | None, str], None]
"""Called with the cell that is done, or None while one is rendered, and a text to show. Raises KeyboardInterrupt."""


def render_cells(
    plan: Plan, scene: Scene, blocks: list[list[Cell]], output: Path, run: str, notify: CellCallback
) -> list[Failure]:
    """Render cells; return those that failed.

    All methods are opened and their kernels compiled before any is timed. Within a block the methods follow one
    another, so that a machine that changes speed does so for all of them.
    """
    cells = [cell for block in blocks for cell in block]
    needed = [method for method in plan.methods if any(cell.method == method.name for cell in cells)]
    failures: list[Failure] = []
    with ExitStack() as stack:
        try:
            studio = Studio(stack, scene.setting, [method.sampler for method in needed if method.sampler is not None])
        except Exception as error:  # whatever it is, the other scenes can still be measured
            return [failure(cell, error) for cell in cells]
        opened = {method.name: Opened(studio, method, scene.setting, notify) for method in needed}
        for name, method in opened.items():
            notify(None, f"{scene.name}: {name}, warming up")
            method.prepare({cell.budget for cell in cells if cell.method == name})
        for cell in cells:
            text = f"{scene.name}: {cell.method}, {cell.budget.label}, seed {cell.seed}"
            notify(None, text)
            try:
                picture, spp = opened[cell.method].render(cell)
                store(cell, output, picture, spp, run)
            except Exception as error:  # the other cells can still be measured; this cell is reported as a failure
                failures.append(failure(cell, error))
            notify(cell, text)
    return failures


def failure(cell: Cell, error: Exception) -> Failure:
    """Return the record of a cell that failed."""
    return Failure(cell.scene, cell.method, cell.budget.label, cell.seed, one_line(error))


def one_line(error: Exception) -> str:
    """Return the first line of an error's message, after the name of its type unless it is a TracerError."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    message = lines[0] if lines else type(error).__name__
    return message if isinstance(error, TracerError) else f"{type(error).__name__}: {message}"


class Opened:
    """A method on an open scene, and the samples per pixel that its budgets buy."""

    def __init__(self, studio: Studio, plan: MethodPlan, setting: Setting, notify: CellCallback) -> None:
        self.studio, self.plan, self.setting, self.told = studio, plan, setting, notify
        self.spps: dict[Budget, int] = {}
        """Samples per pixel that each budget buys."""
        self.broken: Exception | None = None
        """Why the method cannot render: its cells fail with this error without another try. None if it can."""

    def prepare(self, budgets: set[Budget]) -> None:
        """Compile all kernels, and find the samples per pixel that each budget buys."""
        try:
            self.method = self.open()
            if self.plan.sampler is None:
                steady_seconds(self.method, self.clamp(max(WARM_UP_SPP, 3 * (self.plan.pilot_spp or 1))))
            for budget in sorted(budgets, key=lambda budget: budget.amount):
                self.spps[budget] = int(budget.amount) if budget.kind == "spp" else self.find_spp(budget.amount)
                if self.plan.sampler is not None:
                    # Mitsuba's samplers need kernels of their own for every count, ours the same for all counts.
                    steady_seconds(self.method, self.spps[budget])
        except Exception as error:  # raised again by each of its cells, which are reported as failures
            self.broken = error

    def open(self) -> Method:
        """Return the method as a function of spp and seed."""
        if self.plan.sampler is not None:
            return self.studio.stock(self.plan.sampler, self.plan.denoise)
        foretold = None if self.plan.oracle is None else self.foretell(self.plan.oracle)
        return self.studio.own(self.passed, foretold, self.plan.denoise, **self.plan.settings())

    def foretell(self, by: str) -> Foretold:
        """Return the allocations of an oracle; the scene is measured now unless measurements are kept from before."""
        truth = measure_truth(self.setting, self.studio.view, lambda text: self.told(None, text))
        return cache(lambda spp: oracle.rendered_allocation(truth, self.plan.objective, spp, by))

    def render(self, cell: Cell) -> tuple[TimedPicture, int]:
        """Return the picture of a cell and the samples per pixel that were asked for."""
        if self.broken is not None:
            raise self.broken
        spp = self.spps[cell.budget]
        return self.method(spp, cell.seed), spp

    def passed(self, progress: Progress) -> None:
        """Let a person stop the study while a picture is rendered."""
        self.told(None, "")

    def find_spp(self, seconds: float) -> int:
        """Return the samples per pixel that take ``seconds``, by trials until one takes about as long."""
        spp = self.clamp(WARM_UP_SPP)
        for _ in range(TRIALS):
            pace = seconds / steady_seconds(self.method, spp)
            previous_spp, spp = spp, self.clamp(max(1, round(spp * min(pace, FASTEST_GROWTH))))
            if abs(pace - 1) < TRUSTED or spp == previous_spp:
                break
        return spp

    def clamp(self, spp: int) -> int:
        """Return the number nearest to ``spp`` within the bounds of the method."""
        return max(min(spp, self.plan.max_spp or spp), self.plan.min_spp or 1, self.plan.pilot_spp or 1)


def steady_seconds(method: Method, spp: int) -> float:
    """Return the seconds of a picture without compilation: it is repeated until its time falls no further."""
    seconds = method(spp, 0).seconds
    for _ in range(MOST_REPEATS):
        previous_seconds, seconds = seconds, method(spp, 0).seconds
        if seconds > (1 - TRUSTED) * previous_seconds:
            break
    return seconds
