"""A cluster that is made up: workers of any speed hang, wake, die and answer twice, and the clock is a number."""

from dataclasses import dataclass, field
from math import inf

import numpy as np

from tracer.cluster.round_policy import Observation, RoundPolicy, silent_workers
from tracer.cluster.units import Unit, sample_count
from tracer.cluster.work_balancer import Region

TICK = 0.5
"""Seconds without an answer after which the policy is shown the workers."""
PACE = 1e-3
"""Seconds a sample, of a worker that is as fast as expected."""


@dataclass(eq=False)
class SimulatedWorker:
    """Does one request after the other."""

    name: str
    slowness: float = 1.0
    """Times as long as expected that it takes."""
    hangs: float = inf
    """From when on it does nothing,"""
    wakes: float = inf
    """and until when."""
    dies: float = inf
    repeats: bool = False
    """It answers everything twice."""
    queue: list = field(default_factory=list)
    """Requests, the first of which it works on."""
    began: float = 0.0
    """When it began with that."""

    def done_at(self):
        """Return when it is done with the first request of its queue."""
        if not self.queue:
            return inf
        done = self.began + PACE * sample_count(self.queue[0].unit.counts) * self.slowness
        if self.began < self.wakes and done > self.hangs:
            done += self.wakes - max(self.hangs, self.began)
        return done if done <= self.dies else inf

    def is_hanging(self, now):
        return self.hangs <= now < self.wakes


class SimulatedCluster:
    """Carries out what the policy of a round says."""

    def __init__(self, workers):
        self.workers, self.now = workers, 0.0
        self.answers, self.ignored, self.asked_again, self.idled = 0, 0, [], []

    def draw(self, units, pixel_count, longest=10_000.0):
        """Return the sums (P,) of a round, and when it was done."""
        sums = np.zeros(pixel_count, np.int64)
        policy = RoundPolicy(units, [worker.name for worker in self.workers], ())
        self.follow(policy.begin(self.now), policy)
        while policy.waiting:
            assert self.now < longest, "the round never ends"
            for worker in [worker for worker in self.workers if worker.dies <= self.now]:
                self.bury(worker)
            first = min(self.workers, key=SimulatedWorker.done_at)
            if first.done_at() > self.now + TICK:
                self.now += TICK
                self.follow(policy.observe(self.seen(policy), self.now), policy)
                continue
            self.now = max(self.now, first.done_at())
            request = first.queue.pop(0)
            seconds, first.began = self.now - first.began, self.now
            for _ in range(1 + first.repeats):
                self.answers += 1
                if not request.is_open:
                    self.ignored += 1
                    continue
                sums[request.unit.region.pixels] += request.unit.counts
                self.follow(policy.complete(request, first.name, seconds, self.now), policy)
        return sums, self.now

    def follow(self, orders, policy):
        """Cancel and ask, and note who has nothing to do while units wait."""
        for worker in self.workers:
            # What is drawn already cannot be stopped.
            worker.queue[1:] = [request for request in worker.queue[1:] if request not in orders.cancelled]
        for request in orders.asked:
            named = [worker for worker in self.workers if worker.name == request.worker]
            self.give(request, *(named or [self.least_busy()]))
            if request.unit.requests[0] is not request or request.anew:
                self.asked_again.append((request.worker, self.now))
        if any(policy.pool.kept.values()):
            present = [worker for worker in self.workers if worker.dies > self.now]
            self.idled += [worker.name for worker in present if not worker.queue and not worker.is_hanging(self.now)]

    def give(self, request, worker):
        if not worker.queue:
            worker.began = self.now if not worker.is_hanging(self.now) else worker.wakes
        worker.queue.append(request)

    def bury(self, dead):
        """Take a worker away. What it had goes to one that hangs, if there is any, as that looks idle."""
        self.workers.remove(dead)
        assert self.workers, "nobody is left"
        for request in dead.queue:
            self.give(request, self.least_busy())

    def least_busy(self):
        return min(self.workers, key=lambda worker: (not worker.is_hanging(self.now), len(worker.queue)))

    def seen(self, policy):
        """Return what a scheduler knows of its workers."""
        last_seen = {one.name: one.hangs if one.is_hanging(self.now) else self.now for one in self.workers}
        open_requests = {request for unit in policy.waiting for request in unit.requests}
        holders = {request: one.name for one in self.workers for request in one.queue if request in open_requests}
        idle = {one.name for one in self.workers if not one.queue}
        return Observation([one.name for one in self.workers], silent_workers(last_seen), idle, holders)


def units_of(seconds, workers=(None,), pixels=8):
    """Return units that are expected to take so long (seconds), whose sums the workers have in turn; and all counts."""
    units = []
    for number, each in enumerate(seconds):
        counts = np.full(pixels, round(each / PACE / pixels), np.uint32)
        keeper = workers[number % len(workers)]
        source = None if keeper is None else f"sums {number}"
        region = Region(number * pixels, pixels, source, pace=PACE, worker=keeper)
        units.append(Unit(region, counts, counts))
    return units, np.concatenate([unit.counts for unit in units]).astype(np.int64)
