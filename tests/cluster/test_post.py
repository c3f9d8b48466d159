"""What goes wrong on the way from a worker is heard by who waits for it."""

import asyncio
import time

import pytest
from distributed import CancelledError

from tracer.cluster.crew import Crew
from tracer.cluster.post import Post


class Unreadable:
    """Arrives as something that cannot be unpacked."""

    def __reduce__(self):
        return int, ("no number",)


def make():
    return Unreadable()


def test_a_result_that_cannot_be_unpacked_is_an_outcome(two_workers):
    post = Post(Crew(two_workers, ""))
    future = two_workers.submit(make, pure=False)
    post.listen(future, "about")
    heard, deadline = [], time.monotonic() + 120
    while not heard:
        assert time.monotonic() < deadline
        heard = post.hear()
    ((about, outcome),) = heard
    assert about == "about"
    assert isinstance(outcome, Exception)
    assert not isinstance(outcome, CancelledError)
    assert "no number" in str(outcome)


@pytest.mark.parametrize("error", [TimeoutError(), OSError("gone"), CancelledError("gone")])
def test_what_is_lost_with_its_worker_is_cancelled(two_workers, monkeypatch, error):
    post = Post(Crew(two_workers, ""))

    async def lose(key):
        raise error

    monkeypatch.setattr(post, "result_of", lose)
    future = two_workers.submit(int, pure=False)
    future.result()
    asyncio.run(post.deliver(future, "about"))
    assert isinstance(post.inbox.get(timeout=1)[1], CancelledError)
