"""What is asked of whom, and again of whom, with workers that are made up."""

import time
from collections import namedtuple
from types import SimpleNamespace

import numpy as np
import pytest
from distributed import CancelledError

from tracer.cluster import round_scheduler
from tracer.cluster.remote_estimate import Held
from tracer.cluster.round_scheduler import Spread, anew
from tracer.cluster.sums import packed
from tracer.cluster.work_balancer import Region
from tracer.cluster.work_pool import Pool, Unit
from tracer.errors import ClusterError, SceneMissingError
from tracer.film.estimate import Estimate, Statistics
from tracer.sampling.wavefront import Stretch
from tracer.scene.frame import PlainFrame

PIXELS = 40
FRAME = PlainFrame((1, PIXELS), 0, ["R", "G", "B"], 0, (0, 0, PIXELS, 1))
WORKERS = ["tcp://a", "tcp://b", "tcp://c"]
NO_MOMENTS = SimpleNamespace(moments=None, name="uniform")
Future = namedtuple("Future", "key")


class Crew:
    """Three workers, of whom some are silent, and what they are busy with."""

    address = "tcp://scheduler"

    def __init__(self):
        self.client = SimpleNamespace(processing=lambda: self.busy, status="running", scatter=self.scatter)
        self.busy = {worker: [] for worker in WORKERS}
        self.hanging, self.shipped, self.scattered = set(), [], []

    def workers(self):
        return dict.fromkeys(self.busy, 1)

    def silent(self):
        return set(self.hanging)

    def ship(self, setup):
        self.shipped.append(setup)

    def scatter(self, values, hash):
        self.scattered += values
        return [f"future {len(self.scattered)}"]


class Sent(list):
    """Notes (worker, first pixel, source) of all units that are asked for, and what is cancelled."""

    def __init__(self, post):
        self.post, self.cancelled = post, []
        post.send, post.listen, post.cancel = self.send, lambda *_: None, self.cancelled.extend

    def send(self, pieces, worker, **_):
        pairs = []
        for source, _skip, first, *_rest in pieces:
            self.append((worker, first, source))
            pairs.append((Future(f"drawn {len(self)}"), Future(f"told {len(self)}")))
        return pairs


@pytest.fixture
def spreading():
    """Return who spreads, his crew, what he sends, and an estimate of which one round is to be drawn."""
    crew = Crew()
    found = Spread(crew, "setup", FRAME, NO_MOMENTS, 1 << 20)
    found.present = set(WORKERS)
    estimate = Held(FRAME, 0, 0, gather=found.gather, scatter=found.scatter)
    ones = np.ones(PIXELS, np.uint32)
    estimate.rounds = [Stretch(0, 0 * ones, ones)]
    return SimpleNamespace(it=found, crew=crew, sent=Sent(found.post), estimate=estimate)


def unit(first, size=10, worker=None, source=None, seconds=1.0, skip=0):
    ones = np.ones(size, np.uint32)
    return Unit(Region(first, size, source, skip, None, worker), ones, ones, seconds)


def took(worker="tcp://a", samples=100, opening=0.0, seconds=1.0, drawing=0.5):
    return {"samples": samples, "opening": opening, "drawing": drawing, "seconds": seconds, "worker": worker}


def row(size, count=1, invalid=0):
    singles = {name: np.zeros((1, size, depth), np.float32) for name, depth in (("mean", 3), ("variance", 3))}
    none = {name: np.zeros((1, size, 0), np.float32) for name in ("moments", "peaks")}
    rays, counts = np.ones((1, size), np.float32), np.full((1, size), count, np.uint32)
    return Statistics(counts, np.full((1, size), invalid, np.uint32), rays=rays, **singles, **none)


def test_a_unit_goes_on_from_the_sums_that_there_are(spreading):
    one = unit(10, source="sums", worker="tcp://b", skip=7)
    source, skip, first, size, stretches = spreading.it.piece(spreading.estimate, one, anew=False)
    assert (source, skip, first, size, len(stretches)) == ("sums", 7, 10, 10, 1)
    assert spreading.it.piece(spreading.estimate, one, anew=True)[:4] == (None, 0, 10, 10)


def test_what_is_drawn_anew_goes_on_from_the_sums_of_an_earlier_render(spreading):
    arrays = [np.arange(PIXELS, dtype=np.uint32), np.arange(PIXELS) / 3]
    spreading.estimate.begun = arrays
    before, skip, *_ = spreading.it.piece(spreading.estimate, unit(10, source="sums", skip=7), anew=True)
    assert skip == 0
    assert np.array_equal(before["sums"].packed(), packed(arrays, 10, 10))


def test_the_pace_of_a_unit_is_that_of_drawing_and_its_sums_are_its_own(spreading):
    spreading.estimate.regions = [Region(0, 10), Region(10, 30)]
    one = unit(10, size=30, source="sums", skip=7)
    one.futures = [("late", "late told"), ("whole", "told")]
    spreading.it.settle(spreading.estimate, one, "whole", row(30), took("tcp://b", 50, opening=2.0, seconds=3.0))
    assert spreading.estimate.regions[1] == Region(10, 30, "whole", 0, 1 / 50, "tcp://b")
    assert spreading.sent.cancelled == ["late", "late told"]
    assert spreading.estimate.drawn().sum() == 30


def test_what_is_given_out_begins_with_the_longest(spreading):
    """Counts as 1, 4, 2, 3 of units whose sums one worker has."""
    units = [unit(10 * k, worker="tcp://a", source="sums") for k in range(4)]
    for one, count in zip(units, (1, 4, 2, 3), strict=True):
        one.counts = one.counts * count
    pool = Pool()
    spreading.it.deal_out(spreading.estimate, units, ["tcp://a"], pool)
    assert [first for _, first, _ in spreading.sent] == [10, 30]
    assert [one.region.first for one in pool.kept["tcp://a"]] == [20, 0]


def test_nothing_is_given_to_workers_that_are_silent(spreading):
    spreading.it.silent = {"tcp://b"}
    spreading.it.deal_out(spreading.estimate, [unit(10 * k) for k in range(4)], WORKERS, Pool())
    assert {worker for worker, *_ in spreading.sent} == {"tcp://a", "tcp://c"}


def test_sums_of_who_does_not_answer_are_drawn_anew(spreading):
    spreading.it.silent = {"tcp://b"}
    units = [unit(10 * k, worker=worker, source="sums") for k, worker in enumerate(["tcp://a", "tcp://b", "gone"])]
    spreading.it.give(spreading.estimate, Pool(), "tcp://c", [*units, unit(30)])
    assert {first: source for _, first, source in spreading.sent} == {0: "sums", 10: None, 20: None, 30: None}
    assert {worker for worker, *_ in spreading.sent} == {"tcp://c"}
    assert spreading.it.post.traffic.again == 2


def at_work(spreading, *units, seconds=0.0):
    """Give units to workers "a", "b" and so on, so long ago; return the pool that knows of it."""
    pool = Pool()
    for worker, one in zip(WORKERS, units, strict=False):
        spreading.it.give(spreading.estimate, pool, worker, [one])
        one.sent -= seconds
        spreading.crew.busy[worker] = [one.futures[0][0].key]
    spreading.sent.clear()
    return pool


def test_units_of_a_worker_that_is_gone_are_drawn_anew_at_once(spreading):
    lost, own = unit(0, worker="tcp://a", source="sums"), unit(10)
    pool = at_work(spreading, lost, own)
    del spreading.crew.busy["tcp://a"]
    spreading.it.send_again(spreading.estimate, {lost, own}, [1.0], pool)
    assert spreading.sent == [(None, 0, None)]
    assert len(lost.futures) == 1
    assert "tcp://a" not in pool.at_work


@pytest.mark.parametrize(("seconds", "usual", "again"), [(5.0, 1.0, 1), (3.0, 1.0, 0), (10.0, 4.0, 0), (13.0, 4.0, 1)])
def test_a_late_unit_is_given_to_a_worker_that_has_nothing_to_do(spreading, seconds, usual, again):
    """Late: more than three times as long as others, and more than 4 s."""
    late, other = unit(0), unit(10)
    pool = at_work(spreading, late, other, seconds=seconds)
    other.sent = time.monotonic()
    spreading.it.send_again(spreading.estimate, {late, other}, [usual] * 3, pool)
    assert spreading.sent == [("tcp://c", 0, None)] * again


def test_a_unit_that_waited_for_another_is_not_late(spreading):
    late = unit(0)
    pool = at_work(spreading, late, seconds=100.0)
    spreading.it.last_done["tcp://a"] = time.monotonic() - 1
    spreading.it.send_again(spreading.estimate, {late}, [1.0], pool)
    assert spreading.sent == []


def test_units_of_a_worker_that_hangs_are_given_to_the_others(spreading):
    """What it draws, and what goes on from its sums."""
    units = unit(0), unit(10, worker="tcp://a", source="sums"), unit(20)
    pool = at_work(spreading, *units)
    spreading.crew.hanging = {"tcp://a"}
    spreading.it.send_again(spreading.estimate, set(units), [1.0], pool)
    assert {(first, source) for _, first, source in spreading.sent} == {(0, None), (10, None)}
    assert {worker for worker, *_ in spreading.sent} == {"tcp://b", "tcp://c"}


def test_units_that_dask_moved_to_a_worker_that_hangs_are_given_away_once_more(spreading):
    moved = unit(0)
    pool = at_work(spreading, moved)
    spreading.crew.hanging = {"tcp://a"}
    for times in range(1, 4):
        spreading.it.send_again(spreading.estimate, {moved}, [1.0], pool)
        assert len(spreading.sent) == times
        spreading.crew.busy["tcp://a"] = [whole.key for whole, _ in moved.futures]
    spreading.crew.busy["tcp://b"] = [spreading.crew.busy["tcp://a"].pop()]
    spreading.it.send_again(spreading.estimate, {moved}, [1.0], pool)
    assert len(spreading.sent) == 3


@pytest.mark.parametrize(("seconds", "again"), [(5.0, 0), (9.0, 1)])
def test_what_was_sent_twice_is_late_after_twice_the_time(spreading, seconds, again):
    late = unit(0)
    pool = at_work(spreading, late, seconds=5.0)
    spreading.it.send_again(spreading.estimate, {late}, [1.0], pool)
    assert len(late.futures) == 2
    spreading.sent.clear()
    late.sent -= seconds
    spreading.it.send_again(spreading.estimate, {late}, [1.0], pool)
    assert len(spreading.sent) == again


def test_what_nobody_was_asked_for_is_not_lost(spreading):
    spreading.crew.hanging = {"tcp://a"}
    spreading.it.send_again(spreading.estimate, {unit(0), unit(10, worker="tcp://a")}, [1.0], Pool())
    assert spreading.sent == []


def test_a_scene_is_sent_once_and_asked_for_three_times(spreading):
    one = unit(0)
    for _ in range(3):
        spreading.it.failed(one, spreading.estimate, SceneMissingError("none"))
    assert spreading.crew.shipped == ["setup"]
    assert len(spreading.sent) == 3
    with pytest.raises(SceneMissingError):
        spreading.it.failed(one, spreading.estimate, SceneMissingError("none"))


def test_lost_sums_are_drawn_anew_and_other_errors_are_told(spreading):
    spreading.it.failed(unit(0, source="sums"), spreading.estimate, CancelledError("gone"))
    assert spreading.sent == [(None, 0, None)]
    with pytest.raises(ClusterError, match="cannot load tracer"):
        spreading.it.failed(unit(0), spreading.estimate, ImportError("no such module"))


def test_what_is_cut_off_is_a_region_of_its_own(spreading):
    spreading.estimate.regions = [Region(0, 20), Region(20, 20)]
    pool, waiting, long = Pool(), set(), unit(0, size=20, seconds=8.0)
    pool.gave("tcp://a", [])
    pool.gave("tcp://b", [])
    pool.kept = {"tcp://a": [long]}
    spreading.it.feed(spreading.estimate, pool, "tcp://b", waiting)
    assert [(each.first, each.size) for each in spreading.estimate.regions] == [(0, 5), (5, 15), (20, 20)]
    assert {each.region.first for each in waiting} == {5}
    assert spreading.sent == [("tcp://b", 0, None)]


def test_time_is_that_of_all_workers_together(spreading):
    """Half of 6 s is spent drawing, by three workers."""
    one = unit(0, size=PIXELS)
    spreading.estimate.regions = [one.region]
    spreading.it.post.hear = lambda: [((one, "whole"), (row(PIXELS), took(samples=9, seconds=6.0, drawing=3.0)))]
    (told,) = spreading.it.carry_out(spreading.estimate, [one])
    assert (told.samples, told.seconds_drawing, told.seconds_adding) == (9, 1.0, 1.0)


def test_only_what_is_missing_of_a_round_is_asked_for(spreading):
    """As after a stop: some pixels have what they are to have."""
    before, after = np.full((1, PIXELS), 2, np.uint32), np.full((1, PIXELS), 5, np.uint32)
    spreading.estimate.learn(Region(0, 10), row(10, count=4, invalid=1))
    spreading.estimate.learn(Region(10, 30), row(30, count=2))
    spreading.estimate.regions = [Region(0, 10), Region(10, 30)]
    asked = []
    spreading.it.carry_out = lambda estimate, units: asked.extend(units) or iter(())
    list(spreading.it.draw(spreading.estimate, before, after, 0, 1.0))
    counts = {one.region.first: one.counts.tolist() for one in asked}
    assert sum(map(sum, counts.values())) == 30 * 3
    assert 0 not in counts


def test_what_is_drawn_once_more_has_all_samples_those_that_are_no_numbers_too(spreading):
    spreading.estimate.learn(Region(10, 5), row(5, count=3, invalid=2))
    once_more = anew(spreading.estimate, Region(10, 5, "sums", 4))
    assert once_more.goal.tolist() == once_more.counts.tolist() == [5] * 5
    assert (once_more.region.source, once_more.region.skip) == (None, 0)


def test_sums_are_taken_to_all_workers(spreading):
    """40 pixels to three workers: 14, 14 and 12."""
    whole = Estimate(FRAME)
    arrays = [np.arange(PIXELS).astype(each.dtype) for each in whole.state()[1:]]
    whole.restore([whole.layout, *arrays])
    found = spreading.it.scatter(whole)
    assert [(each.first, each.size, each.skip) for each in found] == [(0, 14, 0), (14, 14, 0), (28, 12, 0)]
    for region, sent in zip(found, spreading.crew.scattered, strict=True):
        assert np.array_equal(sent["sums"].packed(), packed(arrays, region.first, region.size))


def test_sums_of_workers_that_answer_are_fetched_first(spreading, monkeypatch):
    heard, limits = [], []

    class Post:
        traffic = SimpleNamespace()

        def __init__(self, crew):
            pass

        def listen(self, source, about):
            heard.append((source, about))

        def hear(self):
            limits.append(len(heard))
            return [(about, CancelledError()) for _, about in heard[-1:]] if len(limits) <= 3 else []

    monkeypatch.setattr(round_scheduler, "Post", Post)
    monkeypatch.setattr(round_scheduler, "AT_ONCE", 1)
    spreading.it.silent = {"tcp://a"}
    regions = [Region(k, 1, f"sums {k}", worker=worker) for k, worker in enumerate(WORKERS)]
    spreading.it.receive(regions, [], np.zeros(PIXELS, bool))
    assert [source for source, _ in heard][-1] == "sums 0"
    assert limits == [1, 2, 3]
