"""Draw a round on workers: send units, hear of them, and do again what is lost or late."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Generator, Iterable
from dataclasses import dataclass, field, replace
from functools import partial
from statistics import median
from typing import Any

import numpy as np
from distributed import CancelledError, KilledWorker
from numpy.typing import NDArray

from tracer.cluster.crew import Crew
from tracer.cluster.held import Held
from tracer.cluster.regions import Region, deal, divide, seconds_of
from tracer.cluster.setup import Setup, Work, software
from tracer.cluster.sums import Sums, by_source, pack, write
from tracer.cluster.unit import Took, draw_unit, tell
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
GATHER_SECONDS = 0.02
"""Those that are done within so long of each other are heard together, which takes less."""
AT_ONCE = 16
"""Sums that are fetched at a time, each of megabytes."""
HANG_SECONDS = 10.0
"""Nothing comes for so long: whoever has it hangs."""

Inbox = queue.SimpleQueue[tuple[Any, Any]]


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
        estimate.regions = divide(estimate.regions, flat, len(self.workers()))
        units = []
        for region in estimate.regions:
            pixels = slice(region.first, region.first + region.size)
            if flat[pixels].any():
                units.append(Unit(region, flat[pixels], goal[pixels]))
        yield from self.carry_out(estimate, units)

    def carry_out(self, estimate: Held, units: list[Unit]) -> Generator[Pass, None, None]:
        """Have units drawn, and tell of them as they are done."""
        waiting = {unit.region.first: unit for unit in units}
        workers = self.workers()
        spent: list[float] = []
        try:
            self.deal_out(estimate, units, workers)
            while waiting:
                heard = self.hear()
                if not heard:
                    self.send_again(estimate, list(waiting.values()), spent)
                    yield Pass(0)
                for unit, whole, outcome in heard:
                    if waiting.get(unit.region.first) is not unit:
                        continue  # another worker was faster
                    if isinstance(outcome, BaseException):
                        self.failed(unit, estimate, outcome)
                        continue
                    del waiting[unit.region.first]
                    known, took = outcome
                    self.settle(estimate, unit, whole, known, took)
                    spent.append(took["seconds"])
                    drawing, seconds = took["drawing"] / len(workers), took["seconds"] / len(workers)
                    yield Pass(took["samples"], drawing, seconds - drawing)
        finally:
            self.client.cancel([future for unit in waiting.values() for pair in unit.futures for future in pair])

    def deal_out(self, estimate: Held, units: list[Unit], workers: list[str]) -> None:
        """Ask workers for units, the longest first."""
        regions = [unit.region for unit in units]
        if all(region.pace is None for region in regions):
            self.send(estimate, units)
            return
        counts = np.zeros(self.view.pixel_count, np.uint32)
        for unit in units:
            counts[unit.region.first : unit.region.first + unit.region.size] = unit.counts
        seconds = seconds_of(regions, counts)
        assert seconds is not None
        by = deal(regions, seconds, workers)
        for worker in workers:
            own = [k for k in range(len(units)) if by[k] == worker]
            if own:
                own.sort(key=lambda k: -seconds[k])
                self.send(estimate, [units[k] for k in own], worker=worker)

    def send(self, estimate: Held, units: list[Unit], anew: bool = False, worker: str | None = None) -> None:
        """Ask for units; ``anew``: with all samples of their pixels, so that no sums are needed."""
        pieces = [
            (None if anew else one.region.source, one.region.skip, one.region.first, one.goal if anew else one.counts)
            for one in units
        ]
        where = {} if worker is None else {"workers": [worker], "allow_other_workers": True}
        alike = {"setup": self.setup, "work": estimate.work}
        drawn = self.client.map(draw_unit, *zip(*pieces, strict=True), **alike, pure=False, **where)
        told = self.client.map(tell, drawn, pure=False, **where)
        for unit, one, other in zip(units, drawn, told, strict=True):
            unit.futures.append((one, other))
            unit.sent = unit.sent or time.monotonic()
            other.add_done_callback(partial(self.put, (unit, one)))
        self.traffic.units += len(units)
        self.traffic.bytes_sent += sum(counts.nbytes for *_, counts in pieces)

    def put(self, label: Any, future: Any) -> None:
        """Hear that a future is done."""
        self.inbox.put((label, future))

    def hear(self) -> list[tuple[Unit, Any, Any]]:
        """Return units, what they were drawn by and what was told of them, or what went wrong; none after a while."""
        self.require_scheduler()
        try:
            done = [self.inbox.get(timeout=TICK)]
        except queue.Empty:
            return []
        time.sleep(GATHER_SECONDS)
        while not self.inbox.empty():
            done.append(self.inbox.get())
        good = [future for _, future in done if future.status == "finished"]
        found = dict(zip(good, self.fetch(good), strict=True))
        for known, _ in found.values():
            self.traffic.bytes_received += sum(values.nbytes for values in vars(known).values())
        return [(*label, found[future] if future in found else failure_of(future)) for label, future in done]

    def fetch(self, futures: list[Any]) -> list[Any]:
        """Return the results of futures that are done. Raises ClusterError."""
        return self.client.gather(futures, direct=True)

    def workers(self) -> list[str]:
        """Return the addresses of the workers there are. Raises ClusterError."""
        self.require_scheduler()
        found = list(self.crew.workers())
        if not found:
            raise ClusterError(f"The scheduler {self.crew.address} has no workers any more.")
        return found

    def settle(self, estimate: Held, unit: Unit, whole: Any, known: Any, took: Took) -> None:
        """Take in a unit that is done, and forget who else was asked for it."""
        others = [future for pair in unit.futures if pair[0] is not whole for future in pair]
        self.client.cancel(others)
        unit.futures.clear()
        place = next(k for k, region in enumerate(estimate.regions) if region.first == unit.region.first)
        pace = (took["seconds"] - took["opening"]) / max(took["samples"], 1)
        estimate.regions[place] = Region(unit.region.first, unit.region.size, whole, 0, pace, took["worker"])
        estimate.learn(unit.region, known)

    def failed(self, unit: Unit, estimate: Held, error: BaseException) -> None:
        """Ask again for a unit whose sums so far are lost; raise any other error."""
        if isinstance(error, CancelledError) and self.client.status == "running":
            self.send(estimate, [unit], anew=True)
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
            self.send(estimate, [unit], anew=True, worker=worker)

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
            buffer = outcome["sums"].packed()
            self.traffic.bytes_received += buffer.nbytes
            for region in found:
                write(buffer, region, arrays)
        return []

    def scatter(self, estimate: Held, whole: Estimate) -> list[Region]:
        """Take sums to workers; return where they are."""
        arrays = whole.state()[1:]
        size = -(-self.view.pixel_count // len(self.workers()))
        found = []
        for first in range(0, self.view.pixel_count, size):
            pieces = [each[first : first + size] for each in arrays]
            future = self.client.scatter({"sums": Sums(None, pack(pieces))}, hash=False)
            found.append(Region(first, len(pieces[0]), future))
        return found

    def close(self) -> None:
        """Nothing is kept here."""


def anew(estimate: Held, region: Region) -> Unit:
    """Return a unit that draws all samples of a region once more."""
    goal = estimate.drawn().ravel()[region.first : region.first + region.size]
    return Unit(replace(region, source=None, skip=0), goal, goal)


def fetch(future: Any, label: Any, inbox: Inbox) -> None:
    """Put label and result of a future, or what went wrong, into ``inbox`` once it is there.

    In a thread of its own, as the worker that has it may hang.
    """

    def get() -> None:
        try:
            inbox.put((label, future.result()))
        except BaseException as error:
            inbox.put((label, error))

    threading.Thread(target=get, daemon=True).start()


def failure_of(future: Any) -> BaseException:
    """Return why a future has no result."""
    return future.exception() if future.status == "error" else CancelledError(str(future.key))


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
