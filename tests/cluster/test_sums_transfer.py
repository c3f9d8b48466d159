"""Sums go to workers and come from them, with workers that are made up."""

from types import SimpleNamespace

import numpy as np
import pytest
from distributed import CancelledError

from tracer.cluster import sums_transfer
from tracer.cluster.sums import Sums, packed
from tracer.cluster.sums_transfer import fetch_sums, scatter_sums
from tracer.cluster.work_balancer import Region
from tracer.errors import ClusterError

PIXELS = 40
ARRAYS = [np.arange(PIXELS, dtype=np.uint32), np.arange(PIXELS) / 3]


def test_sums_are_taken_to_all_workers():
    """40 pixels in three parts: 14, 14 and 12."""
    scattered = []

    def scatter(values, hash):
        scattered.extend(values)
        return [f"future {len(scattered)}"]

    connection = SimpleNamespace(client=SimpleNamespace(scatter=scatter))
    regions = scatter_sums(connection, ARRAYS, 3)
    assert [(region.first, region.size, region.skip) for region in regions] == [(0, 14, 0), (14, 14, 0), (28, 12, 0)]
    assert [region.source for region in regions] == ["future 1", "future 2", "future 3"]
    for region, sent in zip(regions, scattered, strict=True):
        assert np.array_equal(sent["sums"].packed(), packed(ARRAYS, region.first, region.size))


@pytest.fixture
def answers(monkeypatch):
    """Let messages answer with what is put here, by source, in the order in which they are asked; return who was."""
    answered, asked, waiting = {}, [], []

    class Messages:
        def __init__(self, connection):
            pass

        def listen(self, source, about):
            asked.append(source)
            waiting.append((about, answered.get(source)))

        def hear(self):
            heard = [message for message in waiting if message[1] is not None][:1]
            waiting[:] = [message for message in waiting if not heard or message is not heard[0]]
            return heard

    monkeypatch.setattr(sums_transfer, "Messages", Messages)
    return SimpleNamespace(answered=answered, asked=asked)


def fetched(regions, silent=()):
    arrays, came = [np.zeros_like(array) for array in ARRAYS], np.zeros(PIXELS, bool)
    return arrays, came, fetch_sums(None, regions, silent, arrays, came)


def test_all_regions_of_a_piece_are_written_and_the_piece_is_fetched_once(answers):
    """Two regions of a piece that begins with pixel 10, and one that is lost with its worker."""
    answers.answered["sums"] = {"sums": Sums(None, packed(ARRAYS, 10, 20))}
    answers.answered["lost"] = CancelledError("gone")
    source = "sums"
    regions = [Region(0, 10, "lost"), Region(12, 5, source, 2), Region(20, 10, source, 10), Region(30, 10)]
    arrays, came, byte_count = fetched(regions)
    expected = np.zeros(PIXELS, bool)
    expected[12:17] = expected[20:30] = True
    assert np.array_equal(came, expected)
    for array, whole in zip(arrays, ARRAYS, strict=True):
        assert np.array_equal(array, np.where(expected, whole, 0))
    assert byte_count == 20 * (4 + 8)
    assert sorted(answers.asked) == ["lost", "sums"]


def test_sums_of_workers_that_answer_are_fetched_first(answers, monkeypatch):
    monkeypatch.setattr(sums_transfer, "AT_ONCE", 1)
    regions = [Region(k, 1, f"sums of {worker}", worker=worker) for k, worker in enumerate("abc")]
    answers.answered.update({f"sums of {worker}": CancelledError() for worker in "abc"})
    fetched(regions, silent={"a"})
    assert answers.asked[-1] == "sums of a"
    assert len(answers.asked) == 3


def test_sums_that_do_not_come_are_waited_for_ten_seconds(answers):
    """The clock is the number of times that nothing was heard."""
    answers.answered["b"] = {"sums": Sums(None, packed(ARRAYS, 10, 10))}
    _, came, _ = fetched([Region(0, 10, "a"), Region(10, 10, "b")])
    assert (came[:10].any(), came[10:20].all()) == (False, True)


def test_what_is_no_loss_is_told(answers):
    answers.answered["a"] = ImportError("no such module")
    with pytest.raises(ClusterError, match="cannot load tracer"):
        fetched([Region(0, 10, "a")])
