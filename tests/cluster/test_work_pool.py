"""The end of a round is shared out as workers are done, whatever was expected of them."""

import heapq

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tracer.cluster.work_balancer import Region
from tracer.cluster.work_pool import Pool, Unit, cut

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


def pool_of(at_work, **kept):
    """Return a pool in which ``at_work`` workers have nothing in hand, and units are kept of several."""
    pool = Pool()
    for worker in at_work:
        pool.gave(worker, [])
    pool.kept = dict(kept)
    return pool


def test_about_two_thirds_of_the_time_is_given_out_at_once():
    units = [unit(k, seconds) for k, seconds in enumerate([3, 3, 0.8, 0.8, 0.8, 0.8, 0.8])]
    assert sum(one.seconds for one in Pool().keep_back("a", units)) == 6
    # two of them in any case, one to draw and one to wait
    assert len(Pool().keep_back("a", [unit(0, 6.0), unit(1, 3.0), unit(2, 1.0)])) == 2


def test_who_has_nothing_takes_from_who_has_most_left():
    pool = pool_of("abc", a=[unit(0, 1.0)], b=[unit(1, 1.0), unit(2, 1.0)], c=[])
    taken, _ = pool.take("c")
    assert taken.region.first == PIXELS


def test_a_piece_is_a_share_of_what_is_left_and_the_rest_is_next():
    """Of 8 + 0.5 s left two workers take a quarter each; what is cut off is still the longest."""
    long, short = unit(0, 8.0), unit(1, 0.5)
    pool = pool_of("ab", a=[long, short])
    taken, rest = pool.take("b")
    assert taken is long
    assert abs(taken.seconds - 8.5 / 4) <= 8 / PIXELS
    assert pool.kept["a"] == [rest, short]
    assert rest.seconds == 8 - taken.seconds
    assert pool.take("a")[0] is rest


def test_nothing_is_cut_into_crumbs():
    """A fair share of 0.28 s would be 0.07."""
    assert pool_of("ab", a=[unit(0, 0.28)]).take("a")[1] is None
    taken, rest = pool_of("ab", a=[unit(0, 0.4)]).take("a")
    assert abs(taken.seconds - 0.2) <= 0.4 / PIXELS
    assert rest is not None


def test_of_a_cut_unit_each_part_takes_the_time_of_its_samples():
    counts = np.array([70, 10, 10, 10], np.uint32)
    one = Unit(Region(0, 4), counts, counts, 10.0)
    rest = cut(one, 0.5)
    assert (one.region.size, one.seconds, rest.seconds) == (1, 7.0, 3.0)
