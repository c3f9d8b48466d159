"""Exchange messages with workers through Dask: send units, receive results, and notice workers that do not answer."""

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
from tracer.cluster.round_policy import WORKERS_DIED, Observation
from tracer.cluster.units import UnitRequest
from tracer.cluster.worker_task import draw_unit, reported
from tracer.errors import ClusterError

TICK = 0.5
"""Most seconds to wait for a message: then the render loop goes on without one, so that a person can stop it."""
GONE_SECONDS = 10.0
"""Seconds after which a scheduler that cannot be reached counts as gone."""
LARGEST_GRAPH = "100 GiB"
"""Size of a task graph from which Dask warns. It is set this high because the sums of an earlier render are sent with
the units themselves."""
UNANSWERED = (OSError, TimeoutError, ClosedClientError)
"""Errors that Dask raises if a scheduler does not answer."""

Message = tuple[Any, Any]
"""The subject of a message, as it was given to ``listen``, and the result or the error."""


@dataclass
class Traffic:
    """How much was sent and received."""

    units: int = 0
    """Number of units that were sent."""
    again: int = 0
    """Number of units that were sent once more, to be drawn from their first sample."""
    bytes_sent: int = 0
    """Bytes of counts that were sent."""
    bytes_received: int = 0
    """Bytes of statistics and sums that were received."""
    bytes_of_sums: int = 0
    """Bytes of sums among those received."""


class Messages:
    """Sends units to workers, and receives statistics and sums."""

    def __init__(self, connection: Connection) -> None:
        self.connection, self.client = connection, connection.client
        self.traffic = Traffic()
        self.inbox: queue.SimpleQueue[Message] = queue.SimpleQueue()
        self.unreachable_since: float | None = None

    @contextmanager
    def in_reach(self) -> Iterator[None]:
        """Raise ClusterError if the scheduler does not answer within the block."""
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
        """Return the addresses of all workers. Raises ClusterError if there are none."""
        self.require_scheduler()
        addresses = list(self.connection.workers())
        if not addresses:
            raise ClusterError(f"The scheduler {self.connection.address} has no workers any more.")
        return addresses

    def send(self, pieces: Sequence[tuple[Any, ...]], worker: str | None, **alike: Any) -> list[tuple[Future, Future]]:
        """Send units; return for each the future of what is drawn and the future of what is reported of it.

        ``pieces``: positional arguments of ``draw_unit``, for each unit; ``worker``: address of the worker that is to
        draw them, or None for any; ``alike``: keyword arguments that all units share.
        """
        where = {} if worker is None else {"workers": [worker], "allow_other_workers": True}
        with dask.config.set({"distributed.admin.large-graph-warning-threshold": LARGEST_GRAPH}):
            drawn = self.client.map(draw_unit, *zip(*pieces, strict=True), **alike, pure=False, **where)
        reports = self.client.map(reported, drawn, pure=False, **where)
        self.traffic.units += len(pieces)
        self.traffic.bytes_sent += sum(stretch.nbytes for *_, stretches in pieces for stretch in stretches)
        return list(zip(drawn, reports, strict=True))

    def listen(self, future: Future, about: Any) -> None:
        """Put the result or the error of a future into the inbox when it is done; ``about``: the message's subject."""
        future.add_done_callback(lambda done: self.client.loop.add_callback(self.deliver, done, about))

    async def deliver(self, future: Future, about: Any) -> None:
        """Put a result into the inbox.

        Every result is fetched by itself: Dask gathers several at a time, and a worker that hangs would hold up all.
        """
        outcome: Any = CancelledError(str(future.key))
        if future.status == "error":
            outcome = await future.exception()
        elif future.status == "finished":
            try:
                outcome = await fetch(self.client, future.key)
            except (CancelledError, *UNANSWERED):
                pass  # lost with its worker: the caller has it drawn again
            except Exception as error:  # else the caller would not learn of it, and the render would wait for ever
                outcome = error
        self.inbox.put((about, outcome))

    def hear(self) -> list[Message]:
        """Return all messages that have come; an empty list if none comes within TICK seconds. Raises ClusterError."""
        self.require_scheduler()
        try:
            messages = [self.inbox.get(timeout=TICK)]
        except queue.Empty:
            return []
        while not self.inbox.empty():
            messages.append(self.inbox.get())
        return messages

    def cancel(self, futures: Sequence[Future]) -> None:
        """Cancel tasks whose results nobody waits for any more."""
        if futures:
            with suppress(*UNANSWERED):  # a scheduler that is gone draws nothing; the next call that needs it raises
                self.client.cancel(list(futures))

    def observe(self, requests: Sequence[UnitRequest]) -> Observation:
        """Return what the scheduler knows of its workers, and which worker has which of the requests."""
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
    """Return a result from the worker that has it, or through the scheduler if that worker cannot be reached from here.

    Raises CancelledError if no worker has it.
    """
    holders = await client.scheduler.who_has(keys=[key])
    results, missing, failed, _ = await gather_from_workers(holders, rpc=client.rpc, who=client.id)
    if missing or failed:
        response = await client.scheduler.gather(keys=[key])
        if response["status"] != "OK":
            raise CancelledError(str(key))
        results = response["data"]
    return results[key]


def gone(connection: Connection) -> ClusterError:
    """Return the error for a scheduler that cannot be reached."""
    return ClusterError(f"The scheduler {connection.address} is gone.")


def explained(error: BaseException) -> BaseException:
    """Return an error that a person understands in place of an error of Dask; other errors are returned as they are."""
    if isinstance(error, KilledWorker):
        return ClusterError(WORKERS_DIED)
    if isinstance(error, ImportError | AttributeError):
        return ClusterError(f"A worker cannot load tracer ({error}); install the same version there.")
    return error
