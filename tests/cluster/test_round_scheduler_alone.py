"""What is sent, cancelled and taken in as a round is drawn, with workers that are made up."""

from collections import namedtuple
from types import SimpleNamespace

import numpy as np
import pytest
from distributed import CancelledError

from tracer.cluster import round_scheduler
from tracer.cluster.round_policy import Observation, Orders, RoundPolicy
from tracer.cluster.round_scheduler import RoundScheduler, once_more
from tracer.cluster.units import Unit, UnitRequest
from tracer.cluster.work_balancer import Region
from tracer.errors import ClusterError, SceneMissingError
from tracer.film.estimate import Statistics
from tracer.sampling.wavefront import Stretch
from tracer.scene.frame import PlainFrame

PIXELS = 40
FRAME = PlainFrame((1, PIXELS), 0, ["R", "G", "B"], 0, (0, 0, PIXELS, 1))
WORKERS = ["tcp://a", "tcp://b", "tcp://c"]
NO_MOMENTS = SimpleNamespace(moments=None, name="uniform")
Future = namedtuple("Future", "key")


class Connection:
    """Three workers, of whom some are silent."""

    address = "tcp://scheduler"

    def __init__(self):
        self.client = SimpleNamespace(status="running")
        self.hanging, self.shipped = set(), []

    def workers(self):
        return dict.fromkeys(WORKERS, 1)

    def silent(self):
        return set(self.hanging)

    def ship(self, setup):
        self.shipped.append(setup)


class Sent:
    """Notes (worker, first pixels) of all that is sent at once, what is listened to, and what is cancelled."""

    def __init__(self, messages):
        self.batches, self.requests, self.cancelled, self.futures = [], [], [], 0
        messages.send, messages.cancel = self.send, self.cancelled.extend
        messages.listen = lambda _, request: self.requests.append(request)

    def send(self, pieces, worker, **_):
        self.batches.append((worker, [first for _source, _skip, first, *_ in pieces]))
        pairs = []
        for _ in pieces:
            self.futures += 1
            pairs.append((Future(f"drawn {self.futures}"), Future(f"told {self.futures}")))
        return pairs


@pytest.fixture
def cluster():
    """Return a scheduler, its connection, what it sends, and an estimate of which one round is to be drawn."""
    connection = Connection()
    scheduler = RoundScheduler(connection, "setup", FRAME, NO_MOMENTS, 1 << 20)
    estimate = scheduler.empty()
    ones = np.ones(PIXELS, np.uint32)
    estimate.sums.rounds = [Stretch(0, 0 * ones, ones)]
    sent = Sent(scheduler.messages)
    return SimpleNamespace(scheduler=scheduler, connection=connection, sent=sent, estimate=estimate)


def unit(first, size=10, worker=None, source=None):
    ones = np.ones(size, np.uint32)
    return Unit(Region(first, size, source, 0, None, worker), ones, ones)


def report(worker="tcp://a", samples=100, opening=0.0, seconds=1.0, drawing=0.5):
    return {"samples": samples, "opening": opening, "drawing": drawing, "seconds": seconds, "worker": worker}


def row(size, count=1, invalid=0):
    singles = {name: np.zeros((1, size, depth), np.float32) for name, depth in (("mean", 3), ("variance", 3))}
    none = {name: np.zeros((1, size, 0), np.float32) for name in ("moments", "peaks")}
    work, counts = np.ones((1, size), np.float32), np.full((1, size), count, np.uint32)
    return Statistics(counts, np.full((1, size), invalid, np.uint32), work=work, **singles, **none)


def answer(request, **more):
    return request, (row(request.unit.region.size), report(**more))


def test_what_is_asked_of_a_worker_in_a_row_is_sent_at_once(cluster):
    asked = [(0, "tcp://a", False), (10, "tcp://a", True), (20, "tcp://b", True), (30, None, True)]
    requests = [UnitRequest(unit(first), worker, anew, 0.0) for first, worker, anew in asked]
    cluster.scheduler.follow(Orders([], requests), cluster.estimate)
    assert cluster.sent.batches == [("tcp://a", [0, 10]), ("tcp://b", [20]), (None, [30])]
    assert cluster.sent.requests == requests
    assert [request.futures[0].key for request in requests] == [f"drawn {k}" for k in (1, 2, 3, 4)]
    assert cluster.scheduler.messages.traffic.again == 3


def test_both_futures_of_what_is_given_up_are_cancelled(cluster):
    request = UnitRequest(unit(0), "tcp://a", False, 0.0, ("drawn", "told"))
    cluster.scheduler.follow(Orders([request], []), cluster.estimate)
    assert cluster.sent.cancelled == ["drawn", "told"]


def test_the_pace_of_a_unit_is_that_of_drawing_and_its_sums_are_its_own(cluster):
    cluster.estimate.sums.regions = [Region(0, 10), Region(10, 30)]
    request = UnitRequest(unit(10, size=30, source="sums"), "tcp://b", False, 0.0, ("drawn", "told"))
    told = report("tcp://b", 50, opening=2.0, seconds=3.0)
    cluster.scheduler.take_in(cluster.estimate, request, row(30), told)
    assert cluster.estimate.sums.regions[1] == Region(10, 30, "drawn", 0, 1 / 50, "tcp://b")
    assert cluster.estimate.drawn().sum() == 30


def test_time_is_that_of_all_workers_together(cluster):
    """Half of 6 s is spent drawing, by three workers."""
    whole = unit(0, size=PIXELS)
    cluster.scheduler.messages.hear = lambda: [answer(cluster.sent.requests[0], samples=9, seconds=6.0, drawing=3.0)]
    (told,) = cluster.scheduler.carry_out(cluster.estimate, [whole])
    assert (told.samples, told.drawing.wall, told.adding.wall) == (9, 1.0, 1.0)


def test_only_the_first_answer_is_taken_in(cluster):
    """What another has drawn, too, comes at once with it, and would be added a second time."""
    cluster.scheduler.messages.hear = lambda: [answer(cluster.sent.requests[0], samples=k) for k in (1, 2, 3)]
    passes = list(cluster.scheduler.carry_out(cluster.estimate, [unit(0, size=PIXELS)]))
    assert [each.samples for each in passes] == [1]
    assert cluster.scheduler.messages.traffic.bytes_received == sum(each.nbytes for each in vars(row(PIXELS)).values())


def test_a_round_that_is_left_early_cancels_what_is_under_way(cluster):
    cluster.scheduler.messages.hear = lambda: [answer(cluster.sent.requests[0])]
    cluster.estimate.sums.regions = [Region(10 * k, 10) for k in range(4)]
    drawing = cluster.scheduler.carry_out(cluster.estimate, [unit(10 * k) for k in range(4)])
    next(drawing)
    drawing.close()
    under_way = [future for request in cluster.sent.requests[1:] for future in request.futures]
    assert sorted(cluster.sent.cancelled) == sorted(under_way)


def test_when_nothing_is_heard_workers_are_looked_at_and_a_sign_of_life_is_given(cluster):
    """A worker that was there when the round began is gone; its unit is asked for again, and done."""
    cluster.scheduler.messages.observe = lambda requests: Observation(WORKERS[1:], (), (), {})
    cluster.scheduler.messages.hear = lambda: [answer(again) for again in cluster.sent.requests[1:]]
    units = [unit(0, size=PIXELS, worker="tcp://a", source="sums")]
    passes = list(cluster.scheduler.carry_out(cluster.estimate, units))
    assert [each.samples for each in passes] == [0, 100]
    assert cluster.sent.batches == [("tcp://a", [0]), (None, [0])]


def test_a_worker_that_hangs_when_a_round_begins_gets_nothing(cluster):
    cluster.connection.hanging = {"tcp://b"}
    cluster.scheduler.messages.hear = lambda: [answer(request) for request in cluster.sent.requests]
    cluster.estimate.sums.regions = [Region(10 * k, 10) for k in range(4)]
    list(cluster.scheduler.carry_out(cluster.estimate, [unit(10 * k) for k in range(4)]))
    assert {worker for worker, _ in cluster.sent.batches} == {"tcp://a", "tcp://c"}


def test_a_scene_is_sent_once_and_asked_for_three_times(cluster):
    policy = RoundPolicy([lacking := unit(0)], WORKERS, ())
    policy.begin(0.0)
    for _ in range(3):
        orders = cluster.scheduler.recover(policy, lacking.requests[0], SceneMissingError("none"))
        assert len(orders.asked) == 1
    assert cluster.connection.shipped == ["setup"]
    with pytest.raises(SceneMissingError):
        cluster.scheduler.recover(policy, lacking.requests[0], SceneMissingError("none"))


def test_lost_sums_are_drawn_anew_and_other_errors_are_told(cluster):
    policy = RoundPolicy([lost := unit(0, source="sums")], WORKERS, ())
    policy.begin(0.0)
    (again,) = cluster.scheduler.recover(policy, lost.requests[0], CancelledError("gone")).asked
    assert (again.worker, again.anew) == (None, True)
    with pytest.raises(ClusterError, match="cannot load tracer"):
        cluster.scheduler.recover(policy, again, ImportError("no such module"))


def test_only_what_is_missing_of_a_round_is_asked_for(cluster):
    """As after a stop: some pixels have what they are to have."""
    before, after = np.full((1, PIXELS), 2, np.uint32), np.full((1, PIXELS), 5, np.uint32)
    cluster.estimate.learn(Region(0, 10), row(10, count=4, invalid=1))
    cluster.estimate.learn(Region(10, 30), row(30, count=2))
    asked = []
    cluster.scheduler.carry_out = lambda estimate, units: asked.extend(units) or iter(())
    list(cluster.scheduler.draw(cluster.estimate, before, after, 0, 1.0))
    counts = {each.region.first: each.counts.tolist() for each in asked}
    assert sum(map(sum, counts.values())) == 30 * 3
    assert 0 not in counts


def test_what_is_drawn_once_more_has_all_samples_those_that_are_no_numbers_too(cluster):
    cluster.estimate.learn(Region(10, 5), row(5, count=3, invalid=2))
    again = once_more(cluster.estimate, Region(10, 5, "sums", 4))
    assert again.goal.tolist() == again.counts.tolist() == [5] * 5
    assert (again.region.source, again.region.skip) == (None, 0)


def test_sums_that_do_not_come_are_drawn_again_and_fetched(cluster, monkeypatch):
    """Of two regions the second is lost the first time, and told of by another worker the second time."""
    fetched, drawn = [], []

    def fetch(connection, regions, silent, arrays, came):
        fetched.append([region.source for region in regions])
        for region in regions:
            came[region.pixels] = region.source != "lost"
        return 7

    def carry_out(estimate, units):
        drawn.extend(units)
        for each in units:
            estimate.learn(Region(each.region.first, each.region.size, "drawn again"), row(each.region.size, count=3))
        return iter(())

    monkeypatch.setattr(round_scheduler, "fetch_sums", fetch)
    cluster.scheduler.carry_out = carry_out
    cluster.estimate.learn(Region(0, 10, "sums"), row(10, count=3))
    cluster.estimate.learn(Region(10, 30, "lost"), row(30, count=3))
    cluster.scheduler.gather(cluster.estimate)
    assert fetched == [["sums", "lost"], ["drawn again"]]
    assert [(each.region.first, each.counts.sum()) for each in drawn] == [(10, 90)]
    assert cluster.scheduler.messages.traffic.bytes_of_sums == 14
