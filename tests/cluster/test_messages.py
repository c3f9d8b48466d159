"""What is sent and heard, and when a scheduler is taken to be gone; mostly with a client that is made up."""

import asyncio
import time
from collections import namedtuple
from types import SimpleNamespace

import numpy as np
import pytest
from distributed import CancelledError

from tracer.cluster import messages
from tracer.cluster.connection import Connection
from tracer.cluster.messages import Messages
from tracer.cluster.units import UnitRequest
from tracer.errors import ClusterError
from tracer.sampling.wavefront import Stretch

Future = namedtuple("Future", "key")


class Client:
    """Keeps what it is asked for."""

    def __init__(self):
        self.status, self.asked = "running", []

    def map(self, function, *arguments, **how):
        self.asked.append(how)
        return list(range(len(arguments[0])))


@pytest.fixture
def mail():
    return Messages(SimpleNamespace(client=Client(), address="tcp://there", workers=dict))


def test_a_scheduler_is_gone_when_it_has_not_been_reached_for_ten_seconds(mail, monkeypatch):
    now = [50.0]
    monkeypatch.setattr(messages, "time", SimpleNamespace(monotonic=lambda: now[0]))
    for status, moment in (("running", 50), ("connecting", 60), ("connecting", 69.9), ("running", 75)):
        mail.client.status, now[0] = status, moment
        mail.require_scheduler()
    mail.client.status, now[0] = "connecting", 80
    mail.require_scheduler()  # anew
    now[0] = 90.1
    with pytest.raises(ClusterError, match="tcp://there is gone"):
        mail.require_scheduler()
    mail.client.status, mail.unreachable_since = "closed", None
    with pytest.raises(ClusterError, match="tcp://there is gone"):
        mail.require_scheduler()


def test_units_may_be_drawn_by_others_than_those_that_are_asked(mail):
    counts = np.ones(5, np.uint32)
    pieces = [(None, 0, 0, 5, [Stretch(0, 0 * counts, counts)] * number) for number in (1, 3)]
    assert mail.send(pieces, "tcp://one", setup=1) == [(0, 0), (1, 1)]
    assert all(how["workers"] == ["tcp://one"] and how["allow_other_workers"] for how in mail.client.asked)
    assert (mail.traffic.units, mail.traffic.bytes_sent) == (2, 4 * 2 * 5 * 4)
    mail.send(pieces, None)
    assert "workers" not in mail.client.asked[-1]


def test_all_that_came_is_heard_at_once(mail, monkeypatch):
    monkeypatch.setattr(messages, "TICK", 0.01)
    assert mail.hear() == []
    for k in range(3):
        mail.inbox.put((k, k))
    assert mail.hear() == [(0, 0), (1, 1), (2, 2)]


@pytest.mark.parametrize("failed", [False, True])
@pytest.mark.parametrize("scheduler", ["OK", "error"])
def test_a_result_that_a_worker_does_not_give_comes_by_way_of_the_scheduler(mail, monkeypatch, failed, scheduler):
    async def from_workers(holders, **_):
        assert holders == {"key": ["tcp://one"]}
        return ({}, ["key"], ["key"], []) if failed else ({"key": "from the worker"}, [], [], [])

    async def gather(keys):
        return {"status": scheduler, "data": {keys[0]: "from the scheduler"}}

    async def who_has(keys):
        return {keys[0]: ["tcp://one"]}

    monkeypatch.setattr(messages, "gather_from_workers", from_workers)
    mail.client.scheduler = SimpleNamespace(gather=gather, who_has=who_has)
    mail.client.rpc, mail.client.id = None, None
    if failed and scheduler == "error":
        with pytest.raises(CancelledError):
            asyncio.run(messages.fetch(mail.client, "key"))
    else:
        assert asyncio.run(messages.fetch(mail.client, "key")) == f"from the {'scheduler' if failed else 'worker'}"


class Unreadable:
    """Arrives as something that cannot be unpacked."""

    def __reduce__(self):
        return int, ("no number",)


def make():
    return Unreadable()


def test_a_result_that_cannot_be_unpacked_is_an_outcome(two_workers):
    parcels = Messages(Connection(two_workers, ""))
    future = two_workers.submit(make, pure=False)
    parcels.listen(future, "about")
    heard, deadline = [], time.monotonic() + 120
    while not heard:
        assert time.monotonic() < deadline
        heard = parcels.hear()
    ((about, outcome),) = heard
    assert about == "about"
    assert isinstance(outcome, Exception)
    assert not isinstance(outcome, CancelledError)
    assert "no number" in str(outcome)


@pytest.mark.parametrize("error", [TimeoutError(), OSError("gone"), CancelledError("gone")])
def test_what_is_lost_with_its_worker_is_cancelled(two_workers, monkeypatch, error):
    parcels = Messages(Connection(two_workers, ""))

    async def lose(client, key):
        raise error

    monkeypatch.setattr(messages, "fetch", lose)
    future = two_workers.submit(int, pure=False)
    future.result()
    asyncio.run(parcels.deliver(future, "about"))
    assert isinstance(parcels.inbox.get(timeout=1)[1], CancelledError)


def test_what_is_seen_of_workers_and_requests():
    """ "a" draws one, for another of which "b" will tell; the third waits for a worker, and "c" does nothing."""
    busy = {"a": ("drawn 1", "of somebody else"), "b": ("told 2",), "c": ()}
    client = SimpleNamespace(processing=lambda: busy, status="running")
    mail = Messages(SimpleNamespace(client=client, silent=lambda: {"b"}))
    requests = [
        UnitRequest(None, "a", False, 0.0, (Future(f"drawn {number}"), Future(f"told {number}")))
        for number in (1, 2, 3)
    ]
    seen = mail.observe([*requests, UnitRequest(None, "a", False, 0.0)])
    assert seen.workers == ["a", "b", "c"]
    assert (seen.silent, seen.idle) == ({"b"}, {"c"})
    assert seen.holders == {requests[0]: "a", requests[1]: "b"}
