"""What is asked of whom, and again of whom, at given moments."""

import numpy as np
import pytest

from tracer.cluster.round_policy import (
    LONELY_SECONDS,
    MOST_DEATHS,
    Observation,
    RoundPolicy,
    is_late,
    is_lost,
    silent_workers,
)
from tracer.cluster.units import Unit, UnitRequest
from tracer.cluster.work_balancer import Region
from tracer.errors import ClusterError

WORKERS = ["a", "b", "c"]


def unit(first, size=10, worker=None, source=None, count=1, pace=None):
    counts = np.full(size, count, np.uint32)
    return Unit(Region(first, size, source, 0, pace, worker), counts, counts)


def policy_of(*units, workers=WORKERS, silent=()):
    return RoundPolicy(units, workers, silent)


def told(requests):
    """Return (worker, first pixel, anew) of requests."""
    return [(request.worker, request.unit.region.first, request.anew) for request in requests]


def asked(*units, now=0.0, workers=WORKERS, waits=()):
    """Return a policy that has asked workers "a", "b" and so on for a unit each, and what is seen of that."""
    policy = policy_of(*units, *waits)
    requests = [policy.ask(each, worker, now) for worker, each in zip(WORKERS, units, strict=False)]
    return policy, seen(policy, workers, requests)


def seen(policy, workers=WORKERS, requests=(), silent=()):
    """Return what is seen where each worker has what it was asked for."""
    holders = {request: request.worker for request in requests if request.worker in workers}
    return Observation(list(workers), silent, set(workers) - set(holders.values()), holders)


def with_silent(observed, *silent):
    return Observation(observed.workers, silent, observed.idle, observed.holders)


def test_what_is_given_out_begins_with_the_longest():
    """Counts as 1, 4, 2, 3 of units whose sums one worker has."""
    units = [unit(10 * k, worker="a", source="sums", count=count) for k, count in enumerate((1, 4, 2, 3))]
    policy = policy_of(*units, workers=["a"])
    assert told(policy.begin(0.0).asked) == [("a", 10, False), ("a", 30, False)]
    assert [kept.region.first for kept in policy.pool.kept["a"]] == [20, 0]


def test_nothing_is_given_to_workers_that_hang():
    orders = policy_of(*(unit(10 * k) for k in range(4)), silent={"b"}).begin(0.0)
    assert {request.worker for request in orders.asked} == {"a", "c"}


def test_if_all_hang_they_are_asked_all_the_same():
    orders = policy_of(unit(0), unit(10), silent=set(WORKERS)).begin(0.0)
    assert len(orders.asked) == 2


def test_sums_of_who_does_not_answer_are_drawn_anew():
    units = [unit(10 * k, worker=worker, source="sums") for k, worker in enumerate(["a", "b", "gone", None])]
    policy = policy_of(*units, silent={"b"})
    assert [policy.ask(each, "c", 0.0).anew for each in units] == [False, True, True, False]


def test_a_worker_without_a_unit_of_its_own_begins_with_one_that_is_kept_back():
    """Sums of "a" are so large (1.5 s a unit to move) that none is dealt out to "b"; of the three, one is kept back."""
    units = [unit(300_000 * k, 300_000, "a", "sums", pace=1e-6, count=3) for k in range(3)]
    policy = policy_of(*units, workers=["a", "b"])
    requests = policy.begin(0.0).asked
    assert [request.worker for request in requests].count("b") == 1


def test_a_worker_that_has_enough_gets_nothing():
    units = [unit(10 * k, count=1000, pace=1e-3) for k in range(10)]
    policy = policy_of(*units, workers=["a"])
    requests = policy.begin(0.0).asked
    assert len(requests) == 6
    fed = [policy.complete(request, "a", 1.0, 1.0).asked for request in requests[:5]]
    assert [len(several) for several in fed] == [0, 0, 0, 0, 1]


def test_what_is_done_is_cancelled_with_others_and_expected_no_more():
    policy, _ = asked(slow := unit(0), unit(10))
    again = policy.ask(slow, "c", 5.0, anew=True)
    first = slow.requests[0]
    assert first.is_open
    orders = policy.complete(again, "c", 1.0, 6.0)
    assert orders.cancelled == [first]
    assert not first.is_open
    assert not again.is_open
    assert slow not in policy.waiting
    assert policy.in_hand == {"a": 0, "b": 1, "c": 0}


def test_all_who_were_asked_for_a_unit_that_is_done_get_more_but_for_those_that_hang():
    policy, observed = asked(slow := unit(0), unit(10), waits=[unit(20), unit(30)])
    again = policy.ask(slow, "c", 5.0, anew=True)
    policy.pool.kept = {"a": policy.waiting[2:]}
    policy.observe(with_silent(observed, "a"), 5.1)  # gives "b" and "c" one of those that were kept back each
    policy.pool.kept = {"a": [unit(40), unit(50)]}
    orders = policy.complete(again, "c", 1.0, 6.0)
    assert told(orders.asked) == [("c", 40, False)]


def test_units_of_a_worker_that_is_gone_are_drawn_anew_at_once():
    policy, _ = asked(lost := unit(0, worker="a", source="sums"), unit(10))
    gone = lost.requests[0]
    orders = policy.observe(seen(policy, ["b", "c"]), 1.0)
    assert told(orders.asked) == [(None, 0, True)]
    assert orders.cancelled == [gone]
    assert len(lost.requests) == 1
    assert policy.in_hand["a"] == 0


def test_a_unit_that_another_has_too_is_not_asked_for_again_when_one_is_gone():
    policy, _ = asked(late := unit(0))
    again = policy.ask(late, "b", 5.0, anew=True)
    orders = policy.observe(Observation(["b", "c"], (), {"c"}, {again: "b"}), 6.0)
    assert orders.asked == []
    assert late.requests == [again]


@pytest.mark.parametrize(("seconds", "usual", "again"), [(5.0, 1.0, 1), (3.0, 1.0, 0), (10.0, 4.0, 0), (13.0, 4.0, 1)])
def test_a_late_unit_is_given_to_a_worker_that_has_nothing_to_do(seconds, usual, again):
    """Late: more than three times as long as others, and more than 4 s."""
    policy, observed = asked(unit(0), other := unit(10))
    other.requests[0].sent = seconds
    policy.unit_seconds = [usual] * 3
    assert told(policy.observe(observed, seconds).asked) == [("c", 0, True)] * again


def test_who_has_nothing_to_do_takes_what_is_kept_back_before_what_is_late():
    policy, observed = asked(unit(0), unit(10), waits=[kept := unit(20)])
    policy.pool.kept, policy.unit_seconds = {"a": [kept]}, [1.0]
    assert told(policy.observe(observed, 100.0).asked) == [("c", 20, False)]
    assert {request.worker for request in policy.observe(observed, 100.1).asked} == {"c"}  # as it is still idle


def test_before_any_is_done_patience_is_ten_times_as_long():
    policy, observed = asked(unit(0))
    assert policy.observe(observed, 40.0).asked == []
    assert len(policy.observe(observed, 40.1).asked) == 1


def test_a_unit_that_waited_for_another_is_not_late():
    _, observed = asked(late := unit(0))
    assert is_late(late, observed, {}, 100.0, 4.0)
    assert not is_late(late, observed, {"a": 99.0}, 100.0, 4.0)
    assert is_late(late, observed, {"b": 99.0}, 100.0, 4.0)  # who has nothing to do with it


def test_each_time_a_unit_was_asked_for_again_doubles_patience():
    policy, observed = asked(late := unit(0))
    for times, patience in enumerate((4.0, 8.0, 16.0)):
        assert not is_late(late, observed, {}, 100.0 * times + patience, 4.0)
        assert is_late(late, observed, {}, 100.0 * times + patience + 0.1, 4.0)
        policy.ask(late, "b", 100.0 * (times + 1), anew=True)


def test_units_of_a_worker_that_hangs_are_given_to_the_others():
    """What it draws, and what goes on from its sums."""
    policy, observed = asked(unit(0), unit(10, worker="a", source="sums"), unit(20))
    orders = policy.observe(with_silent(observed, "a"), 1.0)
    assert sorted(told(orders.asked)) == [("b", 0, True), ("c", 10, True)]


def test_units_that_dask_moved_to_a_worker_that_hangs_are_given_away_once_more():
    policy, _ = asked(moved := unit(0))
    for times in range(1, 4):
        held = dict.fromkeys(moved.requests, "a")
        policy.observe(Observation(WORKERS, {"a"}, {"b", "c"}, held), 1.0)
        assert len(moved.requests) == 1 + times
    assert policy.observe(Observation(WORKERS, {"a"}, {"b", "c"}, {**held, moved.requests[-1]: "b"}), 1.0).asked == []


def request(worker="a", sums_of=None, anew=False):
    return UnitRequest(unit(0, worker=sums_of, source=sums_of and "sums"), worker, anew, 0.0)


@pytest.mark.parametrize(
    ("made", "holder", "lost"),
    [
        (request(), "a", True),
        (request(), "b", False),
        (request(), None, False),  # it waits for a worker
        (request("b", sums_of="a"), "b", True),
        (request("b", sums_of="a"), None, True),  # it waits for sums
        (request("b", sums_of="a", anew=True), "b", False),
        (request("b", sums_of="b"), "b", False),
    ],
)
def test_what_is_lost_if_one_worker_hangs(made, holder, lost):
    made.unit.requests.append(made)
    observed = Observation(WORKERS, {"a"}, (), {} if holder is None else {made: holder})
    assert is_lost(made.unit, observed) == lost


def test_what_nobody_was_asked_for_is_not_lost():
    policy = policy_of(unit(0), unit(10, worker="a", source="sums"))
    assert policy.observe(seen(policy, silent={"a"}), 100.0).asked == []


def test_a_scene_is_asked_for_three_times():
    policy, _ = asked(lacking := unit(0))
    for _ in range(3):
        (again,) = policy.miss_scene(lacking.requests[0], 0.0).asked
        assert told([again]) == [(None, 0, False)]
    assert policy.miss_scene(lacking.requests[0], 0.0) is None


def test_lost_sums_are_drawn_anew_by_whoever_has_time():
    policy, _ = asked(lost := unit(0, worker="a", source="sums"))
    assert told(policy.lose(lost.requests[0], 1.0).asked) == [(None, 0, True)]
    assert len(lost.requests) == 1


def test_what_is_cut_off_waits_too():
    long = unit(0, size=20, count=400, pace=1e-3)
    policy = policy_of(long, workers=["a", "b"])
    policy.pool.kept, long.seconds = {"a": [long]}, 8.0
    (fed,) = policy.feed("b", 0.0)
    assert [(each.region.first, each.region.size) for each in policy.waiting] == [(0, 5), (5, 15)]
    assert told([fed]) == [("b", 0, False)]


def test_who_was_not_heard_of_for_ten_seconds_hangs_unless_nobody_was():
    assert silent_workers({"a": 100.0, "b": 89.9, "c": 90.1}) == {"b"}
    assert silent_workers({"a": 1.0, "b": 2.0}) == set()
    assert silent_workers({}) == set()


def see_workers_come_and_go(policy, times):
    """Let both of two workers be replaced by others, ``times`` times."""
    for turn in range(times):
        policy.observe(seen(policy, [f"a{turn}", f"b{turn}"]), float(turn))


def test_a_round_whose_workers_die_again_and_again_fails():
    policy = policy_of(*(unit(10 * k) for k in range(4)), workers=["a", "b"])
    policy.begin(0.0)
    see_workers_come_and_go(policy, MOST_DEATHS)
    with pytest.raises(ClusterError, match="Workers died"):
        policy.observe(seen(policy, ["c", "d"]), 100.0)


def test_workers_may_die_as_long_as_units_are_done():
    policy = policy_of(*(unit(10 * k) for k in range(4)), workers=["a", "b"])
    policy.begin(0.0)
    see_workers_come_and_go(policy, MOST_DEATHS)
    policy.complete(policy.waiting[0].requests[0], "b4", 1.0, 99.0)
    policy.observe(seen(policy, ["c", "d"]), 100.0)


def test_a_round_waits_for_workers_to_come_but_not_for_ever():
    policy = policy_of(unit(0), workers=["a"])
    policy.begin(0.0)
    for now in (1.0, LONELY_SECONDS):
        policy.observe(seen(policy, []), now)
    policy.observe(seen(policy, ["b"]), LONELY_SECONDS + 1)
    policy.observe(seen(policy, []), LONELY_SECONDS + 2)
    policy.observe(seen(policy, []), 2 * LONELY_SECONDS)
    with pytest.raises(ClusterError, match="All workers are gone"):
        policy.observe(seen(policy, []), 2 * LONELY_SECONDS + 3)
