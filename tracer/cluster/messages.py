"""Talk to workers through Dask: send, hear, and notice who does not answer."""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import dask
from distributed import CancelledError, Future, KilledWorker
from distributed.client import ClosedClientError
from distributed.utils_comm import gather_from_workers

from tracer.cluster.connection import Connection
from tracer.cluster.round_policy import Observation
from tracer.cluster.units import UnitRequest
from tracer.cluster.worker_task import draw_unit, reported
from tracer.errors import ClusterError

TICK = 0.5
"""Seconds after which a person is heard, even if nothing came."""
GONE_SECONDS = 10.0
"""A scheduler that cannot be reached for so long is gone."""
LARGEST_GRAPH = "100 GiB"
"""Of which Dask does not warn: sums go with units where there is no other way."""
UNANSWERED = (OSError, TimeoutError, ClosedClientError)
"""What Dask raises where a scheduler does not answer."""

Message = tuple[Any, Any]
"""What it is about, and a result or what went wrong."""


@dataclass
class Traffic:
    """What was sent and received."""

    units: int = 0
    again: int = 0
    """Units that were given to one more worker."""
    bytes_sent: int = 0
    bytes_received: int = 0
    bytes_of_sums: int = 0
    """Of those received."""


class Messages:
    """Sends units, and brings what is told of them and the sums that they leave."""

    def __init__(self, connection: Connection) -> None:
        self.connection, self.client = connection, connection.client
        self.traffic = Traffic()
        self.inbox: queue.SimpleQueue[Message] = queue.SimpleQueue()
        self.unreachable_since: float | None = None

    @contextmanager
    def in_reach(self) -> Iterator[None]:
        """Raise ClusterError where the scheduler does not answer."""
        try:
            yield
        except UNANSWERED:
            raise gone(self.connection) from None

    def require_scheduler(self) -> None:
        """Raise ClusterError if the scheduler cannot be reached any more."""
        if self.client.status == "running":
            self.unreachable_since = None
            return
        self.unreachable_since = self.unreachable_since or time.monotonic()
        if self.client.status == "closed" or time.monotonic() - self.unreachable_since > GONE_SECONDS:
            raise gone(self.connection)

    def workers(self) -> list[str]:
        """Return the addresses of the workers there are. Raises ClusterError."""
        self.require_scheduler()
        found = list(self.connection.workers())
        if not found:
            raise ClusterError(f"The scheduler {self.connection.address} has no workers any more.")
        return found

    def send(self, pieces: Sequence[tuple[Any, ...]], worker: str | None, **alike: Any) -> list[tuple[Future, Future]]:
        """Ask for units, if it is given from a ``worker``; return what will be drawn and what will be told of it."""
        where = {} if worker is None else {"workers": [worker], "allow_other_workers": True}
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": LARGEST_GRAPH}):
            drawn = self.client.map(draw_unit, *zip(*pieces, strict=True), **alike, pure=False, **where)
        told = self.client.map(reported, drawn, pure=False, **where)
        self.traffic.units += len(pieces)
        self.traffic.bytes_sent += sum(each.nbytes for *_, stretches in pieces for each in stretches)
        return list(zip(drawn, told, strict=True))

    def listen(self, future: Future, about: Any) -> None:
        """Hear the result of a future, or what went wrong, when it is done."""
        future.add_done_callback(lambda done: self.client.loop.add_callback(self.deliver, done, about))

    async def deliver(self, future: Future, about: Any) -> None:
        """Bring a result. Each comes for itself: Dask gathers several at a time, and one that hangs holds up all."""
        outcome: Any = CancelledError(str(future.key))
        if future.status == "error":
            outcome = await future.exception()
        elif future.status == "finished":
            try:
                outcome = await fetch(self.client, future.key)
            except (CancelledError, *UNANSWERED):
                pass  # lost with its worker: whoever waits for it has it drawn again
            except Exception as error:  # else nobody would hear of it, and the render would wait for ever
                outcome = error
        self.inbox.put((about, outcome))

    def hear(self) -> list[Message]:
        """Return what came; nothing after a while. Raises ClusterError."""
        self.require_scheduler()
        try:
            heard = [self.inbox.get(timeout=TICK)]
        except queue.Empty:
            return []
        while not self.inbox.empty():
            heard.append(self.inbox.get())
        return heard

    def cancel(self, futures: Sequence[Future]) -> None:
        """Let go of what nobody waits for any more."""
        if futures:
            with suppress(*UNANSWERED):  # a scheduler that is gone works on nothing; whoever needs it next says so
                self.client.cancel(list(futures))

    def observe(self, requests: Sequence[UnitRequest]) -> Observation:
        """Return what the scheduler knows of its workers, and who has which of the requests."""
        busy = self.client.processing()
        worker_of = {key: worker for worker, keys in busy.items() for key in keys}
        holders = {
            request: worker_of[future.key]
            for request in requests
            for future in reversed(request.futures or ())
            if future.key in worker_of
        }
        return Observation(list(busy), self.connection.silent(), {name for name in busy if not busy[name]}, holders)


async def fetch(client: Any, key: Any) -> Any:
    """Return a result from the worker that has it, or by way of the scheduler if that cannot be reached from here.

    Raises CancelledError if nobody has it.
    """
    holders = await client.scheduler.who_has(keys=[key])
    found, missing, failed, _ = await gather_from_workers(holders, rpc=client.rpc, who=client.id)
    if missing or failed:
        response = await client.scheduler.gather(keys=[key])
        if response["status"] != "OK":
            raise CancelledError(str(key))
        found = response["data"]
    return found[key]


def gone(connection: Connection) -> ClusterError:
    """Return the error for a scheduler that cannot be reached."""
    return ClusterError(f"The scheduler {connection.address} is gone.")


def explained(error: BaseException) -> BaseException:
    """Return an error that a person understands, where it is of Dask's."""
    if isinstance(error, KilledWorker):
        return ClusterError(
            "Workers died over the same unit again and again: Mitsuba crashes, most likely over something in the "
            "scene that it does not check, or their memory runs out."
        )
    if isinstance(error, ImportError | AttributeError):
        return ClusterError(f"A worker cannot load tracer ({error}); install the same version there.")
    return error
