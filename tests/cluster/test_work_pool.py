"""The end of a round is shared out as workers are done, whatever was expected of them."""

import heapq

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tracer.cluster.units import Unit
from tracer.cluster.work_balancer import Region
from tracer.cluster.work_pool import IN_HAND, WorkPool

PIXELS = 40


def unit(number, seconds, worker="a"):
    counts = np.full(PIXELS, 10, np.uint32)
    region = Region(number * PIXELS, PIXELS, source="held", skip=3, worker=worker)
    return Unit(region, counts, counts + 5, seconds)


def finish(pace, units):
    """Return when each of two workers is done with the units of a round, of which "b" has none; and all units."""
    pool = WorkPool()
    clock = dict.fromkeys(pace, 0.0)
    hand = {"a": pool.keep_back("a", units), "b": pool.keep_back("b", [])}
    made = []
    turns = [(0.0, worker) for worker in pace]
    while turns:
        now, worker = heapq.heappop(turns)
        if len(hand[worker]) < IN_HAND:
            taken, _ = pool.take(worker, 2)
            hand[worker] += [taken] * (taken is not None)
        if not hand[worker]:
            continue
        unit_done = hand[worker].pop(0)
        made.append(unit_done)
        clock[worker] = now + unit_done.seconds * pace[worker]
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


def pool_of(**kept):
    """Return a pool in which units are kept of several workers."""
    pool = WorkPool()
    pool.kept = dict(kept)
    return pool


def test_a_pool_that_is_empty_gives_nothing():
    assert pool_of(a=[]).take("a", 2) == (None, None)


def test_a_unit_that_is_shorter_than_a_fair_share_is_given_whole():
    """Of four seconds one worker takes two."""
    taken, rest = pool_of(a=[unit(k, 1.0) for k in range(4)]).take("a", 1)
    assert (taken.seconds, rest) == (1.0, None)


def test_about_two_thirds_of_the_time_is_given_out_at_once():
    units = [unit(k, seconds) for k, seconds in enumerate([3, 3, 0.8, 0.8, 0.8, 0.8, 0.8])]
    assert sum(one.seconds for one in WorkPool().keep_back("a", units)) == 6
    # two of them in any case, one to draw and one to wait
    assert len(WorkPool().keep_back("a", [unit(0, 6.0), unit(1, 3.0), unit(2, 1.0)])) == 2


def test_who_has_nothing_takes_from_who_has_most_left():
    pool = pool_of(a=[unit(0, 1.0)], b=[unit(1, 1.0), unit(2, 1.0)], c=[])
    taken, _ = pool.take("c", 3)
    assert taken.region.first == PIXELS


def test_a_piece_is_a_share_of_what_is_left_and_the_rest_is_next():
    """Of 8 + 0.5 s left two workers take a quarter each; what is cut off is still the longest."""
    long, short = unit(0, 8.0), unit(1, 0.5)
    pool = pool_of(a=[long, short])
    taken, rest = pool.take("b", 2)
    assert taken is long
    assert abs(taken.seconds - 8.5 / 4) <= 8 / PIXELS
    assert pool.kept["a"] == [rest, short]
    assert rest.seconds == 8 - taken.seconds
    assert pool.take("a", 2)[0] is rest


def test_nothing_is_cut_into_crumbs():
    """A fair share of 0.28 s would be 0.07."""
    assert pool_of(a=[unit(0, 0.28)]).take("a", 2)[1] is None
    taken, rest = pool_of(a=[unit(0, 0.4)]).take("a", 2)
    assert abs(taken.seconds - 0.2) <= 0.4 / PIXELS
    assert rest is not None
