"""Draw rounds on workers: carry out what the round policy decides, and report to it what happens."""

from __future__ import annotations

import itertools
import time
from collections.abc import Generator
from dataclasses import replace
from typing import Any

import numpy as np
from distributed import CancelledError

from tracer.cluster.connection import Connection
from tracer.cluster.messages import Messages, explained
from tracer.cluster.remote_estimate import RemoteEstimate
from tracer.cluster.round_policy import Orders, RoundPolicy
from tracer.cluster.sums_transfer import fetch_sums, scatter_sums
from tracer.cluster.units import Unit, UnitRequest, cut_round
from tracer.cluster.work_balancer import Region
from tracer.cluster.worker_setup import RoundSettings, Setup, software
from tracer.cluster.worker_task import UnitReport
from tracer.core.arrays import Counts
from tracer.core.stopwatch import Seconds
from tracer.criteria import Criterion
from tracer.errors import SceneMissingError
from tracer.film.estimate import Estimate, Statistics
from tracer.sampling.samples import moment_counts
from tracer.sampling.wavefront import Stretch
from tracer.scene.view import View
from tracer.session.guidance import is_guided, packed_guide
from tracer.session.local_drawer import Pass


class RoundScheduler:
    """A ``Drawer`` that draws on workers."""

    def __init__(
        self, connection: Connection, setup: Setup, view: View, criterion: Criterion, largest_pass: int
    ) -> None:
        self.connection, self.messages, self.setup = connection, Messages(connection), setup
        self.view, self.kinds = view, moment_counts(view, criterion.moments)
        name = None if criterion.moments is None else criterion.name
        self.settings = RoundSettings(software(), name, largest_pass, 0, 1.0)
        self.shipped = False
        """Whether the scene was sent to workers that do not have it."""

    def empty(self) -> RemoteEstimate:
        """See ``Drawer``."""
        return RemoteEstimate(self.view, *self.kinds, keeper=self)

    def draw(
        self, estimate: RemoteEstimate, before: Counts, after: Counts, seed: int, scale: float
    ) -> Generator[Pass, None, None]:
        """See ``Drawer``. Raises ClusterError."""
        sums, goal = estimate.sums, after.ravel()
        sums.settings = replace(
            self.settings, seed=seed, scale=scale, guided=is_guided(self.view), guide=packed_guide(self.view)
        )
        sums.rounds.append(Stretch(0, before.ravel(), goal))
        counts = goal - estimate.drawn().ravel()
        with self.messages.in_reach():
            sums.regions, units = cut_round(sums.regions, counts, goal, len(self.messages.workers()))
            yield from self.carry_out(estimate, units)

    def carry_out(self, estimate: RemoteEstimate, units: list[Unit]) -> Generator[Pass, None, None]:
        """Have units drawn; yield a ``Pass`` for each as it is done, and an empty one when none came for a while.

        Raises ClusterError.
        """
        workers = self.messages.workers()
        policy = RoundPolicy(units, workers, self.connection.silent())
        try:
            self.follow(policy.begin(time.monotonic()), estimate)
            while policy.waiting:
                answers = self.messages.hear()
                if not answers:
                    seen = self.messages.observe(requests_of(policy.waiting))
                    self.follow(policy.observe(seen, time.monotonic()), estimate)
                    yield Pass(0)
                for request, outcome in answers:
                    if not request.is_open:
                        continue
                    if isinstance(outcome, BaseException):
                        self.follow(self.recover(policy, request, outcome), estimate)
                        continue
                    statistics, report = outcome
                    self.take_in(estimate, request, statistics, report)
                    orders = policy.complete(request, report["worker"], report["seconds"], time.monotonic())
                    self.follow(orders, estimate)
                    drawing, seconds = report["drawing"] / len(workers), report["seconds"] / len(workers)
                    yield Pass(report["samples"], Seconds(drawing), Seconds(seconds - drawing))
        finally:
            self.messages.cancel(futures_of(requests_of(policy.waiting)))

    def follow(self, orders: Orders, estimate: RemoteEstimate) -> None:
        """Cancel and send requests as ordered."""
        self.messages.cancel(futures_of(orders.cancelled))
        for worker, group in itertools.groupby(orders.asked, lambda request: request.worker):
            requests = list(group)
            arguments = [estimate.sums.arguments(request) for request in requests]
            alike = {"setup": self.setup, "settings": estimate.sums.settings}
            self.messages.traffic.again += sum(request.anew for request in requests)
            for request, futures in zip(requests, self.messages.send(arguments, worker, **alike), strict=True):
                request.futures = futures
                self.messages.listen(futures[1], request)

    def take_in(
        self, estimate: RemoteEstimate, request: UnitRequest, statistics: Statistics, report: UnitReport
    ) -> None:
        """Note the statistics of a unit that is done, its pace, and where its sums are."""
        self.messages.traffic.bytes_received += sum(values.nbytes for values in vars(statistics).values())
        region = request.unit.region
        pace = (report["seconds"] - report["opening"]) / max(report["samples"], 1)
        drawn, _ = request.futures or (None, None)
        estimate.learn(Region(region.first, region.size, drawn, 0, pace, report["worker"]), statistics)

    def recover(self, policy: RoundPolicy, request: UnitRequest, error: BaseException) -> Orders:
        """Return the orders that follow from a request that failed. Raises the error if it ends the round."""
        if isinstance(error, SceneMissingError):
            orders = policy.miss_scene(request, time.monotonic())
            if orders is not None:
                if not self.shipped:
                    self.connection.ship(self.setup)
                    self.shipped = True
                return orders
        if not isinstance(error, CancelledError):
            raise explained(error) from None
        self.messages.require_scheduler()
        return policy.lose(request, time.monotonic())

    def gather(self, estimate: RemoteEstimate) -> Estimate:
        """Return an estimate in this process with all sums; sums that are lost are drawn again. Raises ClusterError."""
        whole = Estimate(self.view, *self.kinds)
        layout, *arrays = whole.blank()
        came = np.zeros(self.view.pixel_count, bool)

        def missing() -> list[Region]:
            return [region for region in estimate.sums.regions if region.source is not None and not came[region.first]]

        with self.messages.in_reach():
            while regions := missing():
                self.messages.require_scheduler()
                byte_count = fetch_sums(self.connection, regions, self.connection.silent(), arrays, came)
                self.messages.traffic.bytes_received += byte_count
                self.messages.traffic.bytes_of_sums += byte_count
                for _ in self.carry_out(estimate, [once_more(estimate, region) for region in missing()]):
                    pass
        whole.restore([layout, *arrays])
        return whole

    def scatter(self, whole: Estimate) -> list[Region]:
        """Send sums to workers; return where they are. Raises ClusterError."""
        return scatter_sums(self.connection, whole.state()[1:], len(self.messages.workers()))

    def describe(self) -> dict[str, Any]:
        """Return the numbers of workers, of units and of bytes that travelled."""
        return {"workers": len(self.connection.workers()), **vars(self.messages.traffic)}

    def close(self) -> None:
        """Do nothing, as there is nothing to close; see ``Drawer``."""


def once_more(estimate: RemoteEstimate, region: Region) -> Unit:
    """Return a unit that draws all samples of a region again."""
    goal = estimate.drawn().ravel()[region.pixels]
    return Unit(replace(region, source=None, skip=0), goal, goal)


def requests_of(units: list[Unit]) -> list[UnitRequest]:
    """Return all requests for units that may still be answered."""
    return [request for unit in units for request in unit.requests]


def futures_of(requests: list[UnitRequest]) -> list[Any]:
    """Return the futures of requests."""
    return [future for request in requests for future in request.futures or ()]
