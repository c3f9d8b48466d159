"""The end of a round is shared out as workers are done, whatever was expected of them."""

import heapq

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tracer.cluster.pool import Pool, Unit, cut
from tracer.cluster.regions import Region

PIXELS = 40


def unit(number, seconds, worker="a"):
    counts = np.full(PIXELS, 10, np.uint32)
    region = Region(number * PIXELS, PIXELS, source="held", skip=3, worker=worker)
    return Unit(region, counts, counts + 5, seconds)


@given(st.floats(0.0, 1.0), st.lists(st.integers(0, 50), min_size=1, max_size=30))
def test_both_parts_of_a_cut_are_the_whole(share, counts):
    whole = np.array(counts, np.uint32)
    one = Unit(Region(7, len(counts), source="held", skip=3), whole, 2 * whole, 4.0)
    rest = cut(one, share)
    parts = [one] if rest is None else [one, rest]
    assert np.array_equal(np.concatenate([part.counts for part in parts]), whole)
    assert np.array_equal(np.concatenate([part.goal for part in parts]), 2 * whole)
    at = 0
    for part in parts:
        assert (part.region.first, part.region.skip, part.region.size) == (7 + at, 3 + at, len(part.counts))
        at += part.region.size
    assert at == len(counts)
    assert abs(sum(part.seconds for part in parts) - 4.0) < 1e-9


def finish(pace, units):
    """Return when each of two workers is done with the units of a round, of which "b" has none; and all units."""
    pool = Pool()
    clock = dict.fromkeys(pace, 0.0)
    hand = {"a": pool.keep_back("a", units), "b": []}
    pool.keep_back("b", [])
    for worker, several in hand.items():
        pool.gave(worker, several)
    made = []
    turns = [(0.0, worker) for worker in pace]
    while turns:
        now, worker = heapq.heappop(turns)
        taken, _ = pool.take(worker)
        if taken is not None:
            hand[worker].append(taken)
            pool.gave(worker, [taken])
        if not hand[worker]:
            continue
        one = hand[worker].pop(0)
        assert worker in pool.done(one)
        made.append(one)
        clock[worker] = now + one.seconds * pace[worker]
        heapq.heappush(turns, (clock[worker], worker))
    assert not any(pool.kept.values())
    return clock, made


@given(st.floats(0.5, 2.0))
def test_a_worker_that_has_nothing_takes_from_another_and_both_end_together(slower):
    units = [unit(k, 1.0) for k in range(20)]
    clock, made = finish({"a": 1.0, "b": slower}, units)
    assert sorted(one.region.first for one in made)[0] == 0
    assert sum(one.region.size for one in made) == 20 * PIXELS
    assert len({one.region.first for one in made}) == len(made)
    # 13 are given at once; what is kept back evens out as much as it can.
    assert clock["b"] <= clock["a"] + 2 * slower
    assert clock["a"] <= 13.0 + 2.0 or clock["a"] <= clock["b"] + 1.5


def test_a_worker_that_has_enough_gets_nothing():
    pool = Pool()
    given_out = pool.keep_back("a", [unit(k, 1.0) for k in range(10)])
    assert len(given_out) == 6
    pool.gave("a", given_out)
    assert pool.take("a") == (None, None)
    for one in given_out[:5]:
        pool.done(one)
    taken, rest = pool.take("a")
    assert taken is not None
    assert rest is None  # a fair share of four seconds is more than a unit
