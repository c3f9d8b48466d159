"""The picture of workers is that of one process, bit for bit, also when it goes on from the other's checkpoint."""

from pathlib import Path

import numpy as np
import pytest

import tracer
from tracer import scenes
from tracer.cluster import work_balancer
from tracer.cluster.connection import connected, own_cluster
from tracer.errors import SceneError, SettingsError
from tracer.session import checkpoint

LAYERS = ("image", "samples", "stderr", "complexity", "importance", "cost")
SCENE = Path(scenes.__file__).parent / "spheres_and_rods.xml"
SIZE = 96


def render(**settings):
    return tracer.render(SCENE, size=SIZE, **{"spp": 32, **settings})


def same(one, other):
    for name in LAYERS:
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert one.report.noise == other.report.noise
    rounds = [[(each.samples, each.least, each.most) for each in result.report.rounds] for result in (one, other)]
    assert rounds[0] == rounds[1]


@pytest.mark.parametrize(
    "settings",
    [{}, {"criterion": "rigau"}, {"unbiased": True, "spp": 64}, {"noise": 0.3}, {"criterion": "uniform", "seed": 5}],
    ids=str,
)
def test_two_workers_make_the_picture_of_one_process(two_workers, settings):
    same(render(cluster=two_workers, **settings), render(**settings))


def test_workers_choose_lights_by_what_the_client_has_learned(two_workers):
    lamps = Path(scenes.__file__).parent / "many_lights.xml"
    settings = {"size": 160, "spp": 32, "guide": True}
    alone = tracer.render(lamps, **settings)
    assert any(note.startswith("Guided: ") for note in alone.report.notes)
    same(tracer.render(lamps, cluster=two_workers, **settings), alone)
    same(
        tracer.render(lamps, cluster=two_workers, **{**settings, "guide": None}), tracer.render(lamps, size=160, spp=32)
    )


def seconds_by_samples(units, counts):
    return [1e-6 * work_balancer.samples_of(unit, counts) for unit in units]


@pytest.mark.parametrize("seconds", [pytest.param(1e-4, marks=pytest.mark.slow), 0.02])
def test_the_size_of_units_does_not_matter(two_workers, monkeypatch, seconds):
    monkeypatch.setattr(work_balancer, "LEAST_SECONDS", seconds)
    monkeypatch.setattr(work_balancer, "MOST_SECONDS", seconds)
    monkeypatch.setattr(work_balancer, "FIRST_SAMPLES", 8000)
    # By the samples of a unit, not by how long they take: on a slow machine there would be ever more of them.
    monkeypatch.setattr(work_balancer, "seconds_of", seconds_by_samples)
    same(render(cluster=two_workers), render())


@pytest.mark.slow
@pytest.mark.parametrize("criterion", ["uniform", "fused"])
def test_rays_that_meet_two_surfaces_take_the_same_one(two_workers, tmp_path, monkeypatch, criterion):
    """Which one depends on the rays beside them: packets that begin anew with each unit change sums."""
    monkeypatch.setattr(work_balancer, "FIRST_SAMPLES", 1 << 17)
    room = Path(scenes.__file__).parent / "window_interior.xml"
    sums = []
    for cluster in (None, two_workers):
        path = tmp_path / f"{len(sums)}.ckpt"
        tracer.render(room, size=256, spp=61, criterion=criterion, cluster=cluster, checkpoint=path)
        sums.append(checkpoint.read(path).arrays)
    assert sums[0].keys() == sums[1].keys()
    for name, values in sums[0].items():
        assert np.array_equal(values, sums[1][name]), name


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2, 4])
def test_the_number_of_workers_does_not_matter(workers):
    same(render(cluster=workers, spp=64), render(spp=64))


@pytest.mark.slow
def test_a_worker_may_have_several_threads():
    from distributed import LocalCluster

    with (
        LocalCluster(1, threads_per_worker=4, host="127.0.0.1", dashboard_address=None, memory_limit=0) as cluster,
        connected(cluster) as client,
    ):
        same(render(cluster=client), render())


@pytest.mark.slow
@pytest.mark.parametrize("part", [0.1, 0.4, 0.8])
@pytest.mark.parametrize("first", ["workers", "alone"])
def test_either_goes_on_from_the_others_checkpoint(two_workers, tmp_path, monkeypatch, part, first):
    monkeypatch.setattr(work_balancer, "FIRST_SAMPLES", 8000)
    for module in ("sampling.passes", "session.local_drawer"):
        monkeypatch.setattr(f"tracer.{module}.PASS_SIZES", (5000, 5000, 5000))
    path = tmp_path / "state.ckpt"
    whole = render()
    drawn = sum(each.samples for each in whole.report.rounds)
    who = [{"cluster": two_workers}, {}]
    if first == "alone":
        who.reverse()
    stopped = render(checkpoint=path, progress=lambda now: now.done < part * drawn, **who[0])
    assert stopped.report.stopped_by == "person"
    same(render(checkpoint=path, resume=True, **who[1]), whole)


def test_progress_shows_the_picture_so_far(two_workers):
    seen = []
    render(cluster=two_workers, progress=lambda now: seen.append((now.done, now.image.mean(), now.samples.sum())))
    assert seen[-1][0] == 32 * SIZE * 72
    assert all(image > 0 for done, image, _ in seen if done)  # a sign of life may come before the first unit


def test_what_cannot_be_sent_is_refused(cornell, two_workers):
    with pytest.raises(SettingsError, match="a scene is a file"):
        tracer.render(cornell(), cluster=two_workers)
    with pytest.raises(SettingsError, match="number of workers, an address"):
        render(cluster=0)


def test_a_scene_that_does_not_load_is_a_sentence(scene_file, two_workers):
    with pytest.raises(SceneError, match="has no sensor"):
        tracer.render(scene_file('<emitter type="constant"/>'), cluster=two_workers)


def test_a_clusters_workers_can_be_reached_from_this_machine_alone():
    with own_cluster(1) as cluster:
        assert cluster.scheduler_address.startswith("tcp://127.0.0.1:")
        assert all(worker["host"] == "127.0.0.1" for worker in cluster.scheduler_info["workers"].values())
