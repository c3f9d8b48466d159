"""Draw a round on workers: send units, hear of them, and do again what is lost or late."""

from __future__ import annotations

import queue
import time
from collections.abc import Generator, Iterable
from dataclasses import dataclass, field, replace
from statistics import median
from typing import Any

import numpy as np
from distributed import CancelledError, KilledWorker
from numpy.typing import NDArray

from tracer.cluster.crew import Crew
from tracer.cluster.held import Held
from tracer.cluster.regions import Region, divide, largest_unit
from tracer.cluster.setup import Setup, Work, software
from tracer.cluster.sums import Inbox, by_source, fetch, pack, write
from tracer.cluster.unit import draw_unit, tell
from tracer.criteria import Criterion
from tracer.draw import moment_counts
from tracer.errors import ClusterError
from tracer.estimate import Estimate
from tracer.here import Counts, Pass
from tracer.scene import View

TICK = 0.5
"""Seconds after which a person is heard, even if no unit is done."""
LATE = 3.0
"""Times as long as others: a unit that takes more, and more than LATE_SECONDS, is drawn by another worker, too."""
LATE_SECONDS = 4.0
GONE_SECONDS = 10.0
"""A scheduler that cannot be reached for so long is gone."""
AT_ONCE = 16
"""Sums that are fetched at a time, each of megabytes."""
HANG_SECONDS = 10.0
"""Nothing comes for so long: whoever has it hangs."""


@dataclass
class Unit:
    """Samples of consecutive pixels, and the futures that will know of them."""

    region: Region
    counts: NDArray[np.uint32]
    """(P,): samples to draw."""
    goal: NDArray[np.uint32]
    """(P,): samples there are to be afterwards."""
    sent: float = 0.0
    futures: list[tuple[Any, Any]] = field(default_factory=list)
    """What is drawn, and what is told of it: by the first that was asked, and by one that draws all samples anew."""


@dataclass
class Traffic:
    """What was sent and received."""

    units: int = 0
    again: int = 0
    """Units that were drawn by more than one worker."""
    bytes_sent: int = 0
    bytes_received: int = 0
    seconds_waiting: float = 0.0
    """For the last unit of each round, after there was nothing more to give to others."""


class Spread:
    """Draws on workers."""

    def __init__(self, crew: Crew, setup: Setup, view: View, criterion: Criterion, largest_pass: int) -> None:
        self.crew, self.client, self.setup = crew, crew.client, setup
        self.view, self.kinds = view, moment_counts(view, criterion.moments)
        self.work = Work(software(), None if criterion.moments is None else criterion.name, largest_pass, 0, 1.0)
        self.rate: float | None = None
        """Samples a second of a worker."""
        self.traffic = Traffic()
        self.inbox: Inbox = queue.SimpleQueue()
        self.unreachable_since: float | None = None

    def empty(self) -> Held:
        """See ``Drawer``."""
        return Held(self.view, *self.kinds, gather=self.gather, scatter=self.scatter)

    def draw(self, estimate: Held, counts: Counts, seed: int, scale: float) -> Generator[Pass, None, None]:
        """See ``Drawer``. Raises ClusterError."""
        estimate.work = replace(self.work, seed=seed, scale=scale)
        flat = counts.ravel()
        goal = estimate.drawn().ravel() + flat
        most = largest_unit(int(flat.sum()), len(self.crew.workers()), self.rate)
        estimate.regions = divide(estimate.regions, flat, most)
        units = []
        for region in estimate.regions:
            pixels = slice(region.first, region.first + region.size)
            if flat[pixels].any():
                units.append(Unit(region, flat[pixels], goal[pixels]))
        units.sort(key=lambda unit: -int(unit.counts.sum()))
        yield from self.carry_out(estimate, units)

    def carry_out(self, estimate: Held, units: list[Unit]) -> Generator[Pass, None, None]:
        """Have units drawn, and tell of them as they are done."""
        waiting = {unit.region.first: unit for unit in units}
        spent: list[float] = []
        try:
            for unit in units:
                self.send(unit, estimate, anew=False)
            while waiting:
                one = self.hear()
                if one is None:
                    self.send_again(estimate, list(waiting.values()), spent)
                    yield Pass(0)
                    continue
                unit, whole, outcome = one
                if unit.region.first not in waiting or waiting[unit.region.first] is not unit:
                    continue
                if isinstance(outcome, BaseException):
                    self.failed(unit, estimate, outcome)
                    continue
                del waiting[unit.region.first]
                known, took = outcome
                self.settle(estimate, unit, whole, known)
                spent.append(time.monotonic() - unit.sent)
                yield self.passed(took, known)
        finally:
            for unit in waiting.values():
                self.client.cancel([future for pair in unit.futures for future in pair])

    def send(self, unit: Unit, estimate: Held, anew: bool, workers: list[str] | None = None) -> None:
        """Ask for a unit; ``anew``: with all samples of its pixels, from the first, so that nothing else is needed."""
        region = unit.region
        before, skip = (None, 0) if anew else (region.source, region.skip)
        counts = unit.goal if anew else unit.counts
        place = (before, skip, region.first, counts)
        where = {} if workers is None else {"workers": workers, "allow_other_workers": True}
        whole = self.client.submit(draw_unit, self.setup, estimate.work, *place, pure=False, **where)
        told = self.client.submit(tell, whole, pure=False, **where)
        unit.futures.append((whole, told))
        unit.sent = unit.sent or time.monotonic()
        self.traffic.units += 1
        self.traffic.bytes_sent += counts.nbytes
        fetch(told, (unit, whole), self.inbox)

    def hear(self) -> tuple[Unit, Any, Any] | None:
        """Return a unit, what it was drawn by and what was told of it, or what went wrong; None if nothing came."""
        self.require_scheduler()
        try:
            (unit, whole), outcome = self.inbox.get(timeout=TICK)
        except queue.Empty:
            return None
        return unit, whole, outcome

    def passed(self, took: dict[str, float], known: Any) -> Pass:
        """Return what the loop is told of a unit."""
        samples, workers = int(took["samples"]), max(len(self.crew.workers()), 1)
        self.rate = samples / max(took["seconds"] - took["opening"], 1e-6)
        self.traffic.bytes_received += sum(values.nbytes for values in vars(known).values())
        return Pass(samples, took["drawing"] / workers, (took["seconds"] - took["drawing"]) / workers)

    def settle(self, estimate: Held, unit: Unit, whole: Any, known: Any) -> None:
        """Take in a unit that is done, and forget who else was asked for it."""
        others = [future for pair in unit.futures if pair[0] is not whole for future in pair]
        self.client.cancel(others)
        unit.futures.clear()
        place = next(k for k, region in enumerate(estimate.regions) if region.first == unit.region.first)
        estimate.regions[place] = Region(unit.region.first, unit.region.size, whole)
        estimate.learn(unit.region, known)

    def failed(self, unit: Unit, estimate: Held, error: BaseException) -> None:
        """Ask again for a unit whose sums so far are lost; raise any other error."""
        if isinstance(error, CancelledError) and self.client.status == "running":
            self.send(unit, estimate, anew=True)
            return
        raise explained(error, self.crew.address) from None

    def send_again(self, estimate: Held, units: Iterable[Unit], spent: list[float]) -> None:
        """Let workers that have nothing to do draw units that are late: their worker may be slow, or hang."""
        now = time.monotonic()
        limit = max(LATE_SECONDS, LATE * median(spent)) if spent else 10 * LATE_SECONDS
        late = [unit for unit in units if now - unit.sent > limit and len(unit.futures) == 1]
        if not late:
            return
        idle = [worker for worker, tasks in self.client.processing().items() if not tasks]
        for unit, worker in zip(late, idle, strict=False):
            self.traffic.again += 1
            self.send(unit, estimate, anew=True, workers=[worker])

    def require_scheduler(self) -> None:
        """Raise ClusterError if the scheduler cannot be reached any more."""
        if self.client.status == "running":
            self.unreachable_since = None
            return
        self.unreachable_since = self.unreachable_since or time.monotonic()
        if self.client.status == "closed" or time.monotonic() - self.unreachable_since > GONE_SECONDS:
            raise ClusterError(f"The scheduler {self.crew.address} is gone.")

    def gather(self, estimate: Held) -> Estimate:
        """Return an estimate in this process with all sums. Raises ClusterError."""
        whole = Estimate(self.view, *self.kinds)
        layout, *arrays = whole.state()
        while left := self.receive(estimate.regions, arrays):
            for _ in self.carry_out(estimate, [anew(estimate, region) for region in left]):
                pass
        whole.restore([layout, *arrays])
        return whole

    def receive(self, regions: list[Region], arrays: list[NDArray]) -> list[Region]:
        """Write the sums of regions into ``arrays``; return those that do not come, as if their worker hangs."""
        inbox: Inbox = queue.SimpleQueue()
        missing = by_source(regions)
        waiting: list[list[Region]] = []
        silent = 0.0
        while missing or waiting:
            while missing and len(waiting) < AT_ONCE:
                waiting.append(missing.pop())
                fetch(waiting[-1][0].source, waiting[-1], inbox)
            self.require_scheduler()
            try:
                found, outcome = inbox.get(timeout=TICK)
            except queue.Empty:
                silent += TICK
                if silent < HANG_SECONDS:
                    continue
                return [region for each in waiting for region in each]
            silent = 0.0
            waiting.remove(found)
            if isinstance(outcome, BaseException):
                raise explained(outcome, self.crew.address) from None
            self.traffic.bytes_received += outcome["sums"].nbytes
            for region in found:
                write(outcome["sums"], region, arrays)
        return []

    def scatter(self, estimate: Held, whole: Estimate) -> list[Region]:
        """Take sums to workers; return where they are."""
        arrays = whole.state()[1:]
        size = -(-self.view.pixel_count // max(len(self.crew.workers()), 1))
        found = []
        for first in range(0, self.view.pixel_count, size):
            pieces = [each[first : first + size] for each in arrays]
            future = self.client.scatter({"sums": pack(pieces)}, hash=False)
            found.append(Region(first, len(pieces[0]), future))
        return found

    def close(self) -> None:
        """Nothing is kept here."""


def anew(estimate: Held, region: Region) -> Unit:
    """Return a unit that draws all samples of a region once more."""
    goal = estimate.drawn().ravel()[region.first : region.first + region.size]
    return Unit(replace(region, source=None, skip=0), goal, goal)


def explained(error: BaseException, address: str) -> BaseException:
    """Return an error that a person understands, where it is of Dask's."""
    if isinstance(error, KilledWorker):
        return ClusterError(
            "Workers died over the same unit again and again: Mitsuba crashes, most likely over something in the "
            "scene that it does not check, or their memory runs out."
        )
    if isinstance(error, CancelledError):
        return ClusterError(f"The scheduler {address} is gone.")
    if isinstance(error, ImportError | AttributeError):
        return ClusterError(f"A worker cannot load tracer ({error}); install the same version there.")
    return error
