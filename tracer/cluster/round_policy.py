"""Decide who draws which unit of a round, and who draws it again, without a clock and without messages.

Whoever carries out a round tells what happens, and when; the answer says which requests to send and which to cancel.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median

from tracer.cluster.units import Unit, UnitRequest, sample_count
from tracer.cluster.work_balancer import deal, expected_seconds
from tracer.cluster.work_pool import IN_HAND, WorkPool

LATE = 3.0
"""Times as long as others: a unit that takes more, and more than LATE_SECONDS, is asked of another worker, too."""
LATE_SECONDS = 4.0
"""Below which no unit is late, unless none of the round is done yet: then ten times as long."""
SILENT_SECONDS = 10.0
"""Workers say every 0.5 to 5 seconds that they are there; one that has not for so long hangs."""
MOST_SCENE_TRIES = 3
"""How often a unit is asked for again because a worker had no scene, before the round has failed."""


@dataclass(frozen=True)
class Observation:
    """What is known of all workers at a moment."""

    workers: Sequence[str]
    """Those that there are."""
    silent: Collection[str]
    """Those of them that hang."""
    idle: Collection[str]
    """Those of them that have nothing to do."""
    holders: Mapping[UnitRequest, str]
    """Who has each request; those that still wait for a worker, or for sums, are missing."""


@dataclass
class Orders:
    """What follows from what happened."""

    cancelled: list[UnitRequest] = field(default_factory=list)
    asked: list[UnitRequest] = field(default_factory=list)
    """To be sent; what is asked of a worker in a row can be sent at once."""


class RoundPolicy:
    """Who is asked for what in one round. All times are seconds of whatever clock the caller has."""

    def __init__(self, units: Sequence[Unit], workers: Sequence[str], silent: Collection[str]) -> None:
        self.waiting = list(units)
        """Units that are not done."""
        self.pool = WorkPool()
        """Those of them that nobody was asked for yet."""
        self.workers = list(workers)
        """As last seen, with those that hang."""
        self.answering = [worker for worker in workers if worker not in silent]
        self.in_hand: Counter[str] = Counter()
        """Requests that each worker may still answer."""
        self.last_done: dict[str, float] = {}
        """When each worker was last done with a unit."""
        self.unit_seconds: list[float] = []
        """What the units that are done took."""

    def begin(self, now: float) -> Orders:
        """Ask for most of the units, the longest first; the others are left in the pool."""
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
            own = [unit for unit, name in zip(self.waiting, chosen, strict=True) if name == worker]
            own = self.pool.keep_back(worker, sorted(own, key=lambda unit: -unit.seconds))
            orders.asked += [self.ask(unit, worker, now) for unit in own]
        for worker in workers:
            if not self.in_hand[worker]:  # others have kept back what it can do
                orders.asked += self.feed(worker, now)
        return orders

    def complete(self, request: UnitRequest, worker: str, seconds: float, now: float) -> Orders:
        """Take note that a unit is done, by ``worker`` in ``seconds``, and give those that waited for it more to do."""
        unit = request.unit
        others = [other for other in unit.requests if other is not request]
        asked = [other.worker for other in unit.requests if other.worker in self.answering]
        for answered in list(unit.requests):
            self.withdraw(answered)
        self.waiting.remove(unit)
        self.last_done[worker] = now
        self.unit_seconds.append(seconds)
        free = [name for name in dict.fromkeys([worker, *asked]) if name is not None]
        return Orders(others, [fed for name in free for fed in self.feed(name, now)])

    def lose(self, request: UnitRequest, now: float) -> Orders:
        """Ask whoever has time for a unit whose worker, or whose sums, are gone."""
        self.withdraw(request)
        return Orders(asked=[self.ask(request.unit, None, now, anew=True)])

    def miss_scene(self, request: UnitRequest, now: float) -> Orders | None:
        """Ask again for a unit whose worker had no scene; None: that was in vain too often, the round has failed."""
        if request.unit.scene_tries >= MOST_SCENE_TRIES:
            return None
        request.unit.scene_tries += 1
        self.withdraw(request)
        return Orders(asked=[self.ask(request.unit, None, now, request.anew)])

    def observe(self, seen: Observation, now: float) -> Orders:
        """Ask again for what is lost, or late where a worker has nothing to do; give new workers something."""
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
        kept = [unit for unit in asked if unit not in lost]
        late = [unit for unit in kept if is_late(unit, seen, self.last_done, now, patience)]
        orders.asked += [self.ask(unit, worker, now, anew=True) for unit, worker in zip(late, idle, strict=False)]
        return orders

    def replace_gone(self, now: float) -> Orders:
        """Cancel what was asked of workers that are gone, and ask whoever has time for what nobody else has.

        Left alone, a scheduler waits for the very worker that was asked, if for a moment there was no other.
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
        """Ask a worker that has little left to do for something of the pool, if there is anything."""
        if self.in_hand[worker] >= IN_HAND:
            return []
        unit, rest = self.pool.take(worker, len(self.answering))
        if rest is not None:
            self.waiting.append(rest)
        return [] if unit is None else [self.ask(unit, worker, now)]

    def ask(self, unit: Unit, worker: str | None, now: float, anew: bool = False) -> UnitRequest:
        """Return one more request for a unit, ``anew`` in any case if whoever has its sums does not answer."""
        keeper = unit.region.worker
        lost = keeper is not None and keeper not in self.answering
        request = UnitRequest(unit, worker, anew or lost, now)
        unit.requests.append(request)
        if worker is not None:
            self.in_hand[worker] += 1
        return request

    def withdraw(self, request: UnitRequest) -> None:
        """Expect no answer any more."""
        request.unit.requests.remove(request)
        if request.worker is not None:
            self.in_hand[request.worker] -= 1


def is_late(unit: Unit, seen: Observation, last_done: Mapping[str, float], now: float, patience: float) -> bool:
    """Return whether a unit takes more than ``patience`` seconds, twice as many for each time it was asked for again.

    They count from when it was asked for last, or from when a worker that has it was ``last_done`` with another unit.
    """
    holders = [seen.holders[request] for request in unit.requests if request in seen.holders]
    since = max([request.sent for request in unit.requests] + [last_done.get(worker, 0.0) for worker in holders])
    return now - since > patience * 2 ** (len(unit.requests) - 1)


def is_lost(unit: Unit, seen: Observation) -> bool:
    """Return whether no request for a unit will be answered, as far as is seen.

    Whoever has it hangs, or whoever has the sums that it goes on from. What was asked for again can be lost again: a
    scheduler may move it to a worker that hangs, as that looks idle.
    """
    return all(
        seen.holders.get(request) in seen.silent or (request.needs_sums and unit.region.worker in seen.silent)
        for request in unit.requests
    )


def silent_workers(last_seen: Mapping[str, float]) -> set[str]:
    """Return the workers that were not heard of for long while others were; ``last_seen``: when each was (seconds)."""
    latest = max(last_seen.values(), default=0.0)
    return {worker for worker, seconds in last_seen.items() if latest - seconds > SILENT_SECONDS}
