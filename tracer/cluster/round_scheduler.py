"""Draw a round on workers: deal out units, and have again what is lost or late."""

from __future__ import annotations

import time
from collections.abc import Generator
from dataclasses import replace
from statistics import median
from typing import Any

import numpy as np
from distributed import CancelledError, KilledWorker
from numpy.typing import NDArray

from tracer.cluster.connection import Crew
from tracer.cluster.messages import TICK, Post, explained
from tracer.cluster.remote_estimate import Held
from tracer.cluster.sums import Sums, by_source, packed, write
from tracer.cluster.work_balancer import Region, deal, divide, seconds_of
from tracer.cluster.work_pool import Pool, Unit
from tracer.cluster.worker_setup import Setup, Work, software
from tracer.cluster.worker_task import Took
from tracer.core.arrays import Counts
from tracer.criteria import Criterion
from tracer.errors import SceneMissingError
from tracer.film.estimate import Estimate
from tracer.sampling.samples import moment_counts
from tracer.sampling.wavefront import Stretch
from tracer.scene.view import View
from tracer.session.local_drawer import Pass

LATE = 3.0
"""Times as long as others: a unit that takes more, and more than LATE_SECONDS, is given to another worker, too."""
LATE_SECONDS = 4.0
MOST_TRIES = 3
AT_ONCE = 16
"""Sums that are fetched at a time, each of megabytes."""
HANG_SECONDS = 10.0
"""No sums come for so long: whoever has them hangs."""


class Spread:
    """Draws on workers."""

    def __init__(self, crew: Crew, setup: Setup, view: View, criterion: Criterion, largest_pass: int) -> None:
        self.crew, self.post, self.setup = crew, Post(crew), setup
        self.view, self.kinds = view, moment_counts(view, criterion.moments)
        self.work = Work(software(), None if criterion.moments is None else criterion.name, largest_pass, 0, 1.0)
        self.shipped = False
        self.last_done: dict[str, float] = {}
        """When each worker was last done with a unit."""
        self.present: set[str] = set()
        """Workers that were there when this was last looked at."""
        self.silent: set[str] = set()
        """Workers that were silent when this was last looked at."""

    def empty(self) -> Held:
        """See ``Drawer``."""
        return Held(self.view, *self.kinds, gather=self.gather, scatter=self.scatter)

    def draw(
        self, estimate: Held, before: Counts, after: Counts, seed: int, scale: float
    ) -> Generator[Pass, None, None]:
        """See ``Drawer``. Raises ClusterError."""
        estimate.work = replace(self.work, seed=seed, scale=scale)
        goal = after.ravel()
        estimate.rounds.append(Stretch(0, before.ravel(), goal))
        counts = goal - estimate.drawn().ravel()
        with self.post.in_reach():
            estimate.regions = divide(estimate.regions, counts, len(self.post.workers()))
            units = []
            for region in estimate.regions:
                if counts[region.pixels].any():
                    units.append(Unit(region, counts[region.pixels], goal[region.pixels]))
            yield from self.carry_out(estimate, units)

    def carry_out(self, estimate: Held, units: list[Unit]) -> Generator[Pass, None, None]:
        """Have units drawn, and tell of them as they are done."""
        waiting, pool = set(units), Pool()
        workers = self.post.workers()
        self.present = set(workers)
        spent: list[float] = []
        try:
            self.deal_out(estimate, units, workers, pool)
            while waiting:
                heard = self.post.hear()
                if not heard:
                    self.send_again(estimate, waiting, spent, pool)
                    for worker in self.present - self.silent:
                        self.feed(estimate, pool, worker, waiting)
                    yield Pass(0)
                for (unit, whole), outcome in heard:
                    if unit not in waiting:
                        continue  # another worker was faster
                    if isinstance(outcome, CancelledError) and all(pair[0] is not whole for pair in unit.futures):
                        continue  # given up for another
                    if isinstance(outcome, BaseException):
                        self.failed(unit, estimate, outcome)
                        continue
                    waiting.remove(unit)
                    known, took = outcome
                    self.post.traffic.bytes_received += sum(values.nbytes for values in vars(known).values())
                    self.settle(estimate, unit, whole, known, took)
                    spent.append(took["seconds"])
                    for worker in {took["worker"], *pool.done(unit)}:
                        self.feed(estimate, pool, worker, waiting)
                    drawing, seconds = took["drawing"] / len(workers), took["seconds"] / len(workers)
                    yield Pass(took["samples"], drawing, seconds - drawing)
        finally:
            self.post.cancel([future for unit in waiting for pair in unit.futures for future in pair])

    def deal_out(self, estimate: Held, units: list[Unit], workers: list[str], pool: Pool) -> None:
        """Ask workers for most of the units, the longest first; the others are left in the pool."""
        regions = [unit.region for unit in units]
        counts = np.zeros(self.view.pixel_count, np.uint32)
        for unit in units:
            counts[unit.region.pixels] = unit.counts
        seconds = seconds_of(regions, counts)
        workers = [worker for worker in workers if worker not in self.silent] or workers
        by = deal(regions, seconds, workers)
        for unit, expected in zip(units, seconds, strict=True):
            unit.seconds = expected
        for worker in workers:
            own = [unit for unit, chosen in zip(units, by, strict=True) if chosen == worker]
            self.give(estimate, pool, worker, pool.keep_back(worker, sorted(own, key=lambda unit: -unit.seconds)))

    def give(self, estimate: Held, pool: Pool, worker: str, units: list[Unit]) -> None:
        """Ask a worker for units; those whose sums nobody has who answers it draws from the first sample."""
        lost = [unit for unit in units if unit.region.worker not in {None, *(self.present - self.silent)}]
        self.send(estimate, [unit for unit in units if unit not in lost], worker=worker)
        self.send(estimate, lost, worker=worker, anew=True)
        pool.gave(worker, units)

    def feed(self, estimate: Held, pool: Pool, worker: str, waiting: set[Unit]) -> None:
        """Give a worker that has little left to do something of the pool."""
        unit, rest = pool.take(worker)
        if unit is None:
            return
        if rest is not None:
            waiting.add(rest)
            estimate.cut([unit.region, rest.region])
        self.give(estimate, pool, worker, [unit])

    def send(self, estimate: Held, units: list[Unit], worker: str | None = None, anew: bool = False) -> None:
        """Ask for units; ``anew``: without the sums that a worker has."""
        if not units:
            return
        pieces = [self.piece(estimate, one, anew) for one in units]
        self.post.traffic.again += len(units) if anew else 0
        pairs = self.post.send(pieces, worker, setup=self.setup, work=estimate.work)
        for unit, (whole, told) in zip(units, pairs, strict=True):
            unit.futures.append((whole, told))
            unit.sent = time.monotonic()
            self.post.listen(told, (unit, whole))

    def piece(self, estimate: Held, unit: Unit, anew: bool) -> tuple[Any, int, int, int, list[Stretch]]:
        """Return the arguments of ``draw_unit`` for a unit."""
        region = unit.region
        place = region.first, region.size
        if region.source is not None and not anew:
            return region.source, region.skip, *place, [estimate.rounds[-1].part(*place)]
        # With the unit itself, as a worker that would be given them first may be gone, too.
        begun = None if estimate.begun is None else {"sums": Sums(None, packed(estimate.begun, *place))}
        return begun, 0, *place, estimate.rounds_of(region, unit.goal)

    def settle(self, estimate: Held, unit: Unit, whole: Any, known: Any, took: Took) -> None:
        """Take in a unit that is done, and forget who else was asked for it."""
        self.post.cancel([future for pair in unit.futures if pair[0] is not whole for future in pair])
        unit.futures.clear()
        self.last_done[took["worker"]] = time.monotonic()
        place = next(k for k, region in enumerate(estimate.regions) if region.first == unit.region.first)
        pace = (took["seconds"] - took["opening"]) / max(took["samples"], 1)
        estimate.regions[place] = Region(unit.region.first, unit.region.size, whole, 0, pace, took["worker"])
        estimate.learn(unit.region, known)

    def failed(self, unit: Unit, estimate: Held, error: BaseException) -> None:
        """Ask again for a unit whose sums so far are lost, or whose worker had no scene; raise any other error."""
        if isinstance(error, SceneMissingError) and unit.tries < MOST_TRIES:
            if not self.shipped:
                self.crew.ship(self.setup)
                self.shipped = True
            unit.tries += 1
            unit.futures.clear()
            self.send(estimate, [unit])
            return
        if not isinstance(error, CancelledError):
            raise explained(error) from None
        self.post.require_scheduler()
        self.send(estimate, [unit], anew=True)

    def send_again(self, estimate: Held, units: set[Unit], spent: list[float], pool: Pool) -> None:
        """Have units drawn once more, if their worker hangs, or if they are late and another has nothing to do."""
        busy = self.crew.client.processing()
        self.present, self.silent = set(busy), self.crew.silent()
        for worker in pool.at_work.keys() - self.present:
            # Dask would wait for the same worker, if for a moment there was no other.
            orphans = [unit for unit in pool.at_work.pop(worker) if unit in units]
            self.post.cancel([future for unit in orphans for pair in unit.futures for future in pair])
            for unit in orphans:
                unit.futures.clear()
            self.send(estimate, orphans, anew=True)
        good = [worker for worker in busy if worker not in self.silent]
        worker_of = {key: worker for worker, keys in busy.items() for key in keys}
        asked = [unit for unit in units if unit.futures]
        lost = [unit for unit in asked if self.is_lost(unit, worker_of)]
        for k, worker in enumerate(good):
            self.send(estimate, lost[k :: len(good)], worker, anew=True)
        limit = max(LATE_SECONDS, LATE * median(spent)) if spent else 10 * LATE_SECONDS
        late = [unit for unit in asked if unit not in lost and self.is_late(unit, worker_of, limit)]
        for unit, worker in zip(late, [each for each in good if not busy[each]], strict=False):
            self.send(estimate, [unit], worker, anew=True)

    def is_lost(self, unit: Unit, worker_of: dict[Any, str]) -> bool:
        """Return whether all workers that have a unit are silent, or the one that has the sums it goes on from is.

        A unit that was sent before can be lost again: Dask may move it to a worker that hangs, as that looks idle.
        Once sent again, a unit needs no earlier sums. ``worker_of``: the worker that has each key.
        """
        needs_sums = len(unit.futures) == 1
        return holders(unit, worker_of) <= self.silent or (needs_sums and unit.region.worker in self.silent)

    def is_late(self, unit: Unit, worker_of: dict[Any, str], limit: float) -> bool:
        """Return whether a unit has taken more than ``limit`` seconds, twice as many for each time it was sent again.

        They count from when it was sent, or from when a worker that has it was last done with another unit.
        ``worker_of``: the worker that has each key.
        """
        done = [self.last_done.get(worker, 0.0) for worker in holders(unit, worker_of) if worker is not None]
        return time.monotonic() - max(unit.sent, *done, 0.0) > limit * 2 ** (len(unit.futures) - 1)

    def gather(self, estimate: Held) -> Estimate:
        """Return an estimate in this process with all sums. Raises ClusterError."""
        whole = Estimate(self.view, *self.kinds)
        layout, *arrays = whole.blank()
        came = np.zeros(self.view.pixel_count, bool)

        def missing() -> list[Region]:
            return [each for each in estimate.regions if each.source is not None and not came[each.first]]

        with self.post.in_reach():
            while wanted := missing():
                self.post.require_scheduler()
                self.silent = self.crew.silent()
                self.receive(wanted, arrays, came)
                lost = [anew(estimate, region) for region in missing()]
                self.silent = self.crew.silent() if lost else set()
                for _ in self.carry_out(estimate, lost):
                    pass
        whole.restore([layout, *arrays])
        return whole

    def receive(self, regions: list[Region], arrays: list[NDArray], came: NDArray[np.bool_]) -> None:
        """Write the sums of regions into ``arrays``, and note in ``came`` (P,) those that came."""
        post = Post(self.crew)
        # Last, as they are taken from the end, those of workers that are there.
        wanted = sorted(by_source(regions), key=lambda several: several[0].worker not in self.silent)
        under_way, quiet = 0, 0.0
        while (wanted or under_way) and quiet < HANG_SECONDS:
            while wanted and under_way < AT_ONCE:
                several = wanted.pop()
                post.listen(several[0].source, several)
                under_way += 1
            heard = post.hear()
            quiet = 0.0 if heard else quiet + TICK
            for several, outcome in heard:
                under_way -= 1
                if isinstance(outcome, CancelledError | KilledWorker | SceneMissingError):
                    continue  # lost with its worker, or with one that was to draw it again: see ``gather``
                if isinstance(outcome, BaseException):
                    raise explained(outcome) from None
                sums = outcome["sums"].packed()
                self.post.traffic.bytes_received += sums.nbytes
                self.post.traffic.bytes_of_sums += sums.nbytes
                for region in several:
                    write(sums, region, arrays)
                    came[region.pixels] = True

    def scatter(self, whole: Estimate) -> list[Region]:
        """Take sums to workers; return where they are."""
        arrays = whole.state()[1:]
        size = -(-self.view.pixel_count // len(self.post.workers()))
        found = []
        for first in range(0, self.view.pixel_count, size):
            place = first, min(size, self.view.pixel_count - first)
            (future,) = self.crew.client.scatter([{"sums": Sums(None, packed(arrays, *place))}], hash=False)
            found.append(Region(*place, future))
        return found

    def describe(self) -> dict[str, Any]:
        """Return units and bytes."""
        return {"workers": len(self.crew.workers()), **vars(self.post.traffic)}

    def close(self) -> None:
        """Nothing is kept here."""


def anew(estimate: Held, region: Region) -> Unit:
    """Return a unit that draws the samples of a region once more."""
    goal = estimate.drawn().ravel()[region.pixels]
    return Unit(replace(region, source=None, skip=0), goal, goal)


def holders(unit: Unit, worker_of: dict[Any, str]) -> set[str | None]:
    """Return the workers that have a unit, with None if one of its futures waits for a worker.

    ``worker_of``: the worker that has each key.
    """
    return {next((worker_of[each.key] for each in pair if each.key in worker_of), None) for pair in unit.futures}
