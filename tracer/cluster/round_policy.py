"""Decide which worker draws which unit of a round, and which draws it again, without a clock and without messages.

The caller, which carries out the round, says what happens and when. The answer says which requests to send and which to
cancel.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median

from tracer.cluster.units import Unit, UnitRequest, sample_count
from tracer.cluster.work_balancer import deal, expected_seconds
from tracer.cluster.work_pool import IN_HAND, WorkPool
from tracer.errors import ClusterError

LATE = 3.0
"""A unit is late if it takes more than LATE times the median of the units that are done, and more than LATE_SECONDS.
Another worker is then asked for it, too."""
LATE_SECONDS = 4.0
"""Seconds within which no unit is late. Ten times as long as long as no unit of the round is done."""
SILENT_SECONDS = 10.0
"""A worker that the scheduler has not heard from for this many seconds counts as hanging. Workers report to the
scheduler every 0.5 to 5 seconds."""
MOST_SCENE_TRIES = 3
"""How often a unit may be asked for again because a worker had no scene, before the round fails."""
MOST_DEATHS = 5
"""Number of workers that may die over one unit before the unit is taken to be the cause. A round fails if as many have
gone for each worker that it began with, and meanwhile no unit was done."""
LONELY_SECONDS = 60.0
"""Seconds without any worker after which a round fails."""
WORKERS_DIED = (
    "Workers died over the same unit again and again: Mitsuba crashes, most likely over something in the "
    "scene that it does not check, or their memory runs out."
)
"""Why a round fails whose units end the workers that draw them."""


@dataclass(frozen=True)
class Observation:
    """What is known of all workers at a moment."""

    workers: Sequence[str]
    """All workers that there are."""
    silent: Collection[str]
    """The workers among them that hang."""
    idle: Collection[str]
    """The workers among them that have nothing to do."""
    holders: Mapping[UnitRequest, str]
    """The worker that has each request; requests that still wait for a worker, or for sums, are not in it."""


@dataclass
class Orders:
    """What the caller must do after an event."""

    cancelled: list[UnitRequest] = field(default_factory=list)
    """Requests to cancel."""
    asked: list[UnitRequest] = field(default_factory=list)
    """Requests to send; consecutive requests to the same worker can be sent together."""


class RoundPolicy:
    """Decides which worker is asked for which unit of one round. Times are in seconds of the caller's clock."""

    def __init__(self, units: Sequence[Unit], workers: Sequence[str], silent: Collection[str]) -> None:
        self.waiting = list(units)
        """Units that are not done."""
        self.pool = WorkPool()
        """The units among them that no worker was asked for yet."""
        self.workers = list(workers)
        """All workers, as last observed, with those that hang."""
        self.most_deaths = MOST_DEATHS * len(self.workers)
        """Number of workers that may go without a unit done in between."""
        self.deaths = 0
        """Number of workers that have gone since the last unit was done."""
        self.lonely_since: float | None = None
        """Time since which there is no worker."""
        self.answering = [worker for worker in workers if worker not in silent]
        """The workers among them that do not hang."""
        self.in_hand: Counter[str] = Counter()
        """Number of requests that each worker may still answer."""
        self.last_done: dict[str, float] = {}
        """Time at which each worker was last done with a unit."""
        self.unit_seconds: list[float] = []
        """Seconds that each unit took that is done."""

    def begin(self, now: float) -> Orders:
        """Ask for most of the units, the longest first; keep the others in the pool."""
        workers = self.answering or self.workers
        regions = [unit.region for unit in self.waiting]
        seconds = expected_seconds(
            [sample_count(unit.counts) for unit in self.waiting], [region.pace for region in regions]
        )
        for unit, expected in zip(self.waiting, seconds, strict=True):
            unit.seconds = expected
        chosen = deal(regions, seconds, workers)
        orders = Orders()
        for worker in workers:
            units = [unit for unit, name in zip(self.waiting, chosen, strict=True) if name == worker]
            units = self.pool.keep_back(worker, sorted(units, key=lambda unit: -unit.seconds))
            orders.asked += [self.ask(unit, worker, now) for unit in units]
        for worker in workers:
            if not self.in_hand[worker]:  # it takes units that were kept back for other workers
                orders.asked += self.feed(worker, now)
        return orders

    def complete(self, request: UnitRequest, worker: str, seconds: float, now: float) -> Orders:
        """Note that ``worker`` has drawn a unit in ``seconds``; give more to all workers that were asked for it."""
        unit = request.unit
        needless = [rival for rival in unit.requests if rival is not request]
        asked = [rival.worker for rival in unit.requests if rival.worker in self.answering]
        for answered in list(unit.requests):
            self.withdraw(answered)
        self.waiting.remove(unit)
        self.deaths = 0
        self.last_done[worker] = now
        self.unit_seconds.append(seconds)
        free = [name for name in dict.fromkeys([worker, *asked]) if name is not None]
        return Orders(needless, [next_request for name in free for next_request in self.feed(name, now)])

    def lose(self, request: UnitRequest, now: float) -> Orders:
        """Ask any worker for a unit whose worker, or whose sums, are gone."""
        self.withdraw(request)
        return Orders(asked=[self.ask(request.unit, None, now, anew=True)])

    def miss_scene(self, request: UnitRequest, now: float) -> Orders | None:
        """Ask again for a unit whose worker had no scene; None: it was in vain too often, the round fails."""
        if request.unit.scene_tries >= MOST_SCENE_TRIES:
            return None
        request.unit.scene_tries += 1
        self.withdraw(request)
        return Orders(asked=[self.ask(request.unit, None, now, request.anew)])

    def observe(self, seen: Observation, now: float) -> Orders:
        """Ask again for units that are lost, and idle workers for units that are late; give new workers units.

        Raises ClusterError if there is no hope for the round, as its workers are gone.
        """
        self.count_deaths(seen.workers, now)
        self.workers = list(seen.workers)
        self.answering = [worker for worker in seen.workers if worker not in seen.silent]
        orders = self.replace_gone(now)
        asked = [unit for unit in self.waiting if unit.requests]
        lost = [unit for unit in asked if is_lost(unit, seen)]
        for k, worker in enumerate(self.answering):
            orders.asked += [self.ask(unit, worker, now, anew=True) for unit in lost[k :: len(self.answering)]]
        for worker in sorted(self.answering, key=lambda worker: self.in_hand[worker]):
            orders.asked += self.feed(worker, now)
        busy = {request.worker for request in orders.asked}
        idle = [worker for worker in self.answering if worker in seen.idle and worker not in busy]
        patience = max(LATE * median(self.unit_seconds), LATE_SECONDS) if self.unit_seconds else 10 * LATE_SECONDS
        under_way = [unit for unit in asked if unit not in lost]
        late = [unit for unit in under_way if is_late(unit, seen, self.last_done, now, patience)]
        orders.asked += [self.ask(unit, worker, now, anew=True) for unit, worker in zip(late, idle, strict=False)]
        return orders

    def count_deaths(self, workers: Sequence[str], now: float) -> None:
        """Note which workers are gone. Raises ClusterError if they are too many, or if there was none for long."""
        self.deaths += len(set(self.workers) - set(workers))
        if self.deaths > self.most_deaths:
            raise ClusterError(WORKERS_DIED)
        if workers:
            self.lonely_since = None
            return
        self.lonely_since = now if self.lonely_since is None else self.lonely_since
        if now - self.lonely_since > LONELY_SECONDS:
            raise ClusterError(f"All workers are gone, and none has come for {LONELY_SECONDS:.0f} seconds.")

    def replace_gone(self, now: float) -> Orders:
        """Cancel requests to workers that are gone, and ask any worker for the units that no other worker has.

        Otherwise the scheduler might wait for ever for the worker that is gone: it does so if at some moment there was
        no other worker.
        """
        orders, present = Orders(), {None, *self.workers}
        for unit in self.waiting:
            gone = [request for request in unit.requests if request.worker not in present]
            for request in gone:
                self.withdraw(request)
            if gone and not unit.requests:
                orders.asked.append(self.ask(unit, None, now, anew=True))
            orders.cancelled += gone
        return orders

    def feed(self, worker: str, now: float) -> list[UnitRequest]:
        """Ask a worker that has little left to do for a unit of the pool, if there is one."""
        if self.in_hand[worker] >= IN_HAND:
            return []
        unit, rest = self.pool.take(worker, len(self.answering))
        if rest is not None:
            self.waiting.append(rest)
        return [] if unit is None else [self.ask(unit, worker, now)]

    def ask(self, unit: Unit, worker: str | None, now: float, anew: bool = False) -> UnitRequest:
        """Return one more request for a unit; it is drawn ``anew`` also if the worker with its sums does not answer.

        ``worker``: the worker that is asked, or None for any.
        """
        keeper = unit.region.worker
        lost = keeper is not None and keeper not in self.answering
        request = UnitRequest(unit, worker, anew or lost, now)
        unit.requests.append(request)
        if worker is not None:
            self.in_hand[worker] += 1
        return request

    def withdraw(self, request: UnitRequest) -> None:
        """Expect no answer to a request any more."""
        request.unit.requests.remove(request)
        if request.worker is not None:
            self.in_hand[request.worker] -= 1


def is_late(unit: Unit, seen: Observation, last_done: Mapping[str, float], now: float, patience: float) -> bool:
    """Return whether a unit takes more than ``patience`` seconds, which double each time it is asked for again.

    The seconds count from the last request for it, or from the time at which a worker that has it was ``last_done``
    with another unit, whichever is later.
    """
    holders = [seen.holders[request] for request in unit.requests if request in seen.holders]
    since = max([request.sent for request in unit.requests] + [last_done.get(worker, 0.0) for worker in holders])
    return now - since > patience * 2 ** (len(unit.requests) - 1)


def is_lost(unit: Unit, seen: Observation) -> bool:
    """Return whether, as far as is observed, no request for a unit will be answered.

    A request is lost if the worker that has it hangs, or the worker that has the sums it goes on from. A request that
    was sent again can be lost again: a worker that hangs looks idle, so the scheduler may move a unit to it.
    """
    return all(
        seen.holders.get(request) in seen.silent or (request.needs_sums and unit.region.worker in seen.silent)
        for request in unit.requests
    )


def silent_workers(last_seen: Mapping[str, float]) -> set[str]:
    """Return the workers that were not heard from for SILENT_SECONDS although others were.

    ``last_seen``: time in seconds at which each worker was last heard from.
    """
    latest = max(last_seen.values(), default=0.0)
    return {worker for worker, seconds in last_seen.items() if latest - seconds > SILENT_SECONDS}
