"""Whole rounds of a made-up cluster: all is drawn once, and neither slow nor dead workers hold it up for long."""

import itertools
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cluster.simulation import PACE, TICK, SimulatedCluster, SimulatedWorker, units_of
from tracer.cluster.round_policy import LATE
from tracer.cluster.units import Unit, cut_round
from tracer.cluster.work_balancer import Region

UNIT = 2.0
"""Seconds of a unit, so long that LATE times it is more than LATE_SECONDS."""
NAMES = ["a", "b", "c", "d"]


def workers_of(*slowness, **more):
    """Return workers "a", "b" and so on; ``more``: by name, what else there is to say of one."""
    return [SimulatedWorker(name, slow, **more.get(name, {})) for name, slow in zip(NAMES, slowness, strict=False)]


def drawn(workers, units, counts):
    """Return when a round is done, and its cluster; all samples must be there, each once."""
    cluster = SimulatedCluster(workers)
    sums, makespan = cluster.draw(units, len(counts))
    assert np.array_equal(sums, counts)
    assert not cluster.idled
    return makespan, cluster


def best(slowness, seconds):
    """Return when workers of these speeds would be done with so much work if all ended together."""
    return sum(seconds) / sum(1 / slow for slow in slowness)


@pytest.mark.parametrize("keepers", [(None,), ("a",), ("a", "b", "c", "d")])
def test_equal_workers_end_together(keepers):
    units, counts = units_of([UNIT] * 20, keepers)
    makespan, cluster = drawn(workers_of(1, 1, 1, 1), units, counts)
    assert makespan <= 1.1 * best([1] * 4, [UNIT] * 20)
    assert not cluster.asked_again


@given(
    st.lists(st.floats(1.0, 2.0), min_size=1, max_size=4),
    st.lists(st.floats(0.2, 1.5), min_size=1, max_size=40),
    st.booleans(),
)
def test_workers_of_different_speed_end_within_thirty_percent_of_the_best(slowness, seconds, kept):
    """As long as none is more than twice as slow: it is given 65 percent of an even share, and 2 * 0.65 is 1.3.

    Beside that, whoever is last may have begun two units when the others ended.
    """
    units, counts = units_of(seconds, NAMES[: len(slowness)] if kept else (None,))
    makespan, _ = drawn(workers_of(*slowness), units, counts)
    assert makespan <= 1.3 * best(slowness, seconds) + 2 * max(seconds) * max(slowness)


def test_a_worker_that_is_much_slower_is_not_waited_for():
    """Ten times as slow, it would take 65 s for the 65 percent of its share that it is given."""
    units, counts = units_of([UNIT] * 20)
    makespan, cluster = drawn(workers_of(1, 1, 1, 10), units, counts)
    alone = best([1, 1, 1], [UNIT] * 20)
    assert makespan <= alone + (LATE + 2) * UNIT
    assert cluster.ignored == 0  # what it waits for is cancelled; what it draws is not awaited


@pytest.mark.parametrize("moment", [0.0, 1.0, 3.0, 5.0, 7.0, 8.5, 9.5])
@pytest.mark.parametrize("keepers", [(None,), ("a", "b", "c", "d")])
def test_a_hang_costs_no_more_than_three_units(moment, keepers):
    """Over a round in which nothing happens: what it had, three units at most, is drawn by the others meanwhile."""
    units, counts = units_of([UNIT] * 20, keepers)
    makespan, cluster = drawn(workers_of(1, 1, 1, 1, d={"hangs": moment}), units, counts)
    assert makespan <= best([1, 1, 1, 1], [UNIT] * 20) + 3 * UNIT
    assert cluster.asked_again
    assert {name for name, _ in cluster.asked_again} <= {"a", "b", "c"}


def test_what_is_asked_for_again_in_vain_is_waited_for_twice_as_long():
    """ "a" says that it is there, and draws nothing; "b", who is asked for its unit, hangs; then "c" is asked."""
    units, counts = units_of([UNIT] * 3)
    makespan, cluster = drawn(workers_of(1e6, 1, 1, b={"hangs": UNIT + 0.1}), units, counts)
    (first, second), (again, last) = cluster.asked_again
    assert (first, again) == ("b", "c")
    assert LATE * UNIT < second <= LATE * UNIT + 2 * TICK
    assert 2 * LATE * UNIT < last - second <= 2 * LATE * UNIT + 2 * TICK
    assert makespan == pytest.approx(last + UNIT)


@pytest.mark.parametrize("moment", [0.3, 2.0, 4.1, 8.0, 9.9])
def test_a_death_costs_no_more_than_what_is_drawn_again(moment):
    """It is seen as soon as nothing is heard for a tick."""
    units, counts = units_of([UNIT] * 20, NAMES)
    makespan, _ = drawn(workers_of(1, 1, 1, 1, d={"dies": moment}), units, counts)
    assert makespan <= best([1, 1, 1], [UNIT] * 20) + 2 * UNIT + 4 * TICK


def test_what_dask_moves_to_a_worker_that_hangs_is_drawn_all_the_same():
    units, counts = units_of([UNIT] * 20, NAMES)
    makespan, _ = drawn(workers_of(1, 1, 1, 1, c={"hangs": 1.0}, d={"dies": 2.5}), units, counts)
    assert makespan <= best([1, 1], [UNIT] * 20) + (LATE + 3) * UNIT


def test_what_is_answered_late_and_twice_counts_once():
    units, counts = units_of([UNIT] * 20, NAMES)
    workers = workers_of(1, 1, 1, 1, c={"hangs": 1.0, "wakes": 14.2}, d={"repeats": True})
    _, cluster = drawn(workers, units, counts)
    assert cluster.ignored >= 5 + 1  # all of "d", and what "c" had begun
    assert cluster.answers - cluster.ignored >= 20


EVENTS = st.fixed_dictionaries(
    {
        "slowness": st.floats(0.5, 8.0),
        "hangs": st.sampled_from([inf, inf, 0.0, 0.7, 2.5, 6.0]),
        "sleeps": st.sampled_from([inf, 3.0, 12.0]),
        "dies": st.sampled_from([inf, inf, 0.4, 3.1, 9.0]),
        "repeats": st.booleans(),
    }
)


@given(st.lists(EVENTS, max_size=3), st.lists(st.integers(0, 3000), min_size=1, max_size=60), st.integers(0, 99))
def test_every_sample_is_drawn_once_whatever_happens(events, counts, seed):
    """One worker lives; all others may be slow, hang, wake, die and answer twice."""
    random = np.random.default_rng(seed)
    workers = [SimulatedWorker("a", 1.0)]
    for name, event in zip("bcd", events, strict=False):
        more = {key: value for key, value in event.items() if key != "sleeps"}
        workers.append(SimulatedWorker(name, wakes=event["hangs"] + event["sleeps"], **more))
    counts = np.array(counts, np.uint32)
    borders = np.unique([0, *random.integers(0, len(counts), 5), len(counts)])
    keepers = [None, *(worker.name for worker in workers), "gone"]
    regions = [
        Region(int(first), int(end - first), f"sums {first}", pace=PACE, worker=keepers[random.integers(len(keepers))])
        for first, end in itertools.pairwise(borders)
    ]
    _, units = cut_round(regions, counts, 2 * counts, len(workers))
    drawn(workers, units, counts)


def test_a_round_without_samples_is_done():
    units, counts = [Unit(Region(0, 3), np.zeros(3, np.uint32), np.ones(3, np.uint32))], np.zeros(3, np.int64)
    makespan, _ = drawn(workers_of(1, 1), units, counts)
    assert makespan == 0.0
