"""Workers die, come late, hang or are of another version; schedulers go away."""

import importlib.metadata
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from distributed import Client

import tracer
from conftest import PATIENCE
from tracer import scenes
from tracer.cluster import (
    connection,
    messages,
    round_policy,
    round_scheduler,
    sums_transfer,
    work_balancer,
    worker_setup,
)
from tracer.cluster.connection import connected, own_cluster
from tracer.errors import ClusterError
from tracer.io.atomic import is_running

SCENE = Path(scenes.__file__).parent / "spheres_and_rods.xml"
SETTINGS = {"size": 128, "spp": 64}

pytestmark = pytest.mark.slow


@pytest.fixture
def alone():
    return tracer.render(SCENE, **SETTINGS)


@pytest.fixture(autouse=True)
def small_units(monkeypatch):
    monkeypatch.setattr(work_balancer, "LEAST_SECONDS", 0.05)
    monkeypatch.setattr(work_balancer, "MOST_SECONDS", 0.1)
    monkeypatch.setattr(work_balancer, "FIRST_SAMPLES", 1 << 14)


def same(one, other):
    for name in ("image", "samples", "stderr", "importance"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name


def once(part, action):
    """Return a progress callback that does something when so much is done."""
    done = []

    def progress(now):
        if now.done > part * now.total and not done:
            done.append(now.done)
            action()

    return progress


@pytest.mark.parametrize("part", [0.05, 0.6])
def test_a_worker_that_is_killed_changes_nothing(alone, part):
    with own_cluster(2) as cluster, connected(cluster) as client:
        victim = next(iter(client.run(os.getpid).values()))
        found = tracer.render(SCENE, cluster=client, progress=once(part, lambda: os.kill(victim, 9)), **SETTINGS)
        same(found, alone)
        assert not is_running(victim)


def test_all_workers_may_be_killed(alone):
    with own_cluster(2) as cluster, connected(cluster) as client:
        victims = list(client.run(os.getpid).values())
        kill = once(0.7, lambda: [os.kill(victim, 9) for victim in victims])
        same(tracer.render(SCENE, cluster=client, progress=kill, **SETTINGS), alone)


def test_workers_may_be_killed_after_a_render_goes_on(alone, tmp_path):
    """What was drawn before is in no worker's reach any more."""
    path = tmp_path / "state.ckpt"
    total = SETTINGS["spp"] * SETTINGS["size"] ** 2
    tracer.render(SCENE, checkpoint=path, progress=lambda now: now.done < 0.3 * total, **SETTINGS)
    with own_cluster(2) as cluster, connected(cluster) as client:
        victims = list(client.run(os.getpid).values())
        kill = once(0.6, lambda: [os.kill(victim, 9) for victim in victims])
        same(tracer.render(SCENE, cluster=client, checkpoint=path, resume=True, progress=kill, **SETTINGS), alone)


def test_a_worker_that_comes_late_changes_nothing_and_helps(alone):
    with own_cluster(1) as cluster, connected(cluster) as client:
        drawn_by = set()

        def late():
            cluster.scale(2)
            client.wait_for_workers(2)

        take_in = round_scheduler.RoundScheduler.take_in

        def watch(self, estimate, request, statistics, report):
            drawn_by.add(report["worker"])
            take_in(self, estimate, request, statistics, report)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(round_scheduler.RoundScheduler, "take_in", watch)
            same(tracer.render(SCENE, cluster=client, progress=once(0.2, late), **SETTINGS), alone)
        assert len(drawn_by) == 2


@pytest.mark.parametrize("part", [0.05, 0.9])
def test_a_worker_that_hangs_does_not_hold_up_a_round(alone, monkeypatch, part):
    monkeypatch.setattr(round_policy, "LATE_SECONDS", 1.0)
    monkeypatch.setattr(sums_transfer, "HANG_SECONDS", 2.0)
    monkeypatch.setattr(round_policy, "SILENT_SECONDS", 2.0)
    with own_cluster(2) as cluster, connected(cluster) as client:
        victim = next(iter(client.run(os.getpid).values()))
        try:
            stop = once(part, lambda: os.kill(victim, signal.SIGSTOP))
            same(tracer.render(SCENE, cluster=client, progress=stop, **SETTINGS), alone)
        finally:
            os.kill(victim, signal.SIGCONT)


def slow_down(seconds):
    from tracer.cluster import worker_task

    draw = worker_task.draw_on_device

    def slowly(*arguments):
        time.sleep(seconds)
        return draw(*arguments)

    worker_task.draw_on_device = slowly


def test_a_slow_worker_does_not_hold_up_a_round(monkeypatch):
    monkeypatch.setattr(round_policy, "LATE_SECONDS", 0.5)
    few = {"size": 64, "spp": 32}
    with own_cluster(2) as cluster, connected(cluster) as client:
        slow = next(iter(client.run(os.getpid)))
        tracer.render(SCENE, cluster=client, **few)  # opens and compiles
        start = time.monotonic()
        tracer.render(SCENE, cluster=client, **few)
        slower = 3.0 + time.monotonic() - start  # as slow as the machine is
        client.run(slow_down, slower, workers=[slow])
        start = time.monotonic()
        found = tracer.render(SCENE, cluster=client, **few)
        seconds = time.monotonic() - start
    same(found, tracer.render(SCENE, **few))
    assert found.report.elsewhere["again"] >= 1
    assert seconds < slower * len(found.report.rounds)


def dask(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "distributed.cli." + arguments[0], *map(str, arguments[1:])],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def test_a_scheduler_that_goes_away_leaves_a_checkpoint(alone, tmp_path, monkeypatch):
    monkeypatch.setattr(messages, "GONE_SECONDS", 2.0)
    monkeypatch.setattr(connection, "LONGEST_WAIT", 10.0)
    told, path = tmp_path / "scheduler.json", tmp_path / "state.ckpt"
    scheduler = dask("dask_scheduler", "--host", "127.0.0.1", "--port", 0, "--no-dashboard", "--scheduler-file", told)
    worker = dask("dask_worker", "--scheduler-file", told, "--nthreads", 1, "--no-dashboard", "--no-nanny")
    try:
        while not told.exists():
            time.sleep(0.1)
        with Client(scheduler_file=str(told), timeout=PATIENCE, set_as_default=False) as client:
            client.wait_for_workers(1)
        with pytest.raises(ClusterError, match=r"is gone.*has [0-9.]+ % of the samples; go on with resume=True"):
            tracer.render(SCENE, cluster=str(told), checkpoint=path, progress=once(0.5, scheduler.kill), **SETTINGS)
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.wait()
    same(tracer.render(SCENE, checkpoint=path, resume=True, **SETTINGS), alone)


def test_a_worker_of_another_version_is_named(two_workers, monkeypatch):
    version = importlib.metadata.version
    monkeypatch.setattr(importlib.metadata, "version", lambda name: "3.0" if name == "mitsuba" else version(name))
    worker_setup.software.cache_clear()
    try:
        with pytest.raises(ClusterError, match=r"Worker tcp://.* has Mitsuba 3.9.*, and the client 3.0"):
            tracer.render(SCENE, cluster=two_workers, **SETTINGS)
    finally:
        worker_setup.software.cache_clear()


def test_a_worker_of_another_version_that_comes_late_leaves_a_checkpoint(alone, two_workers, tmp_path, monkeypatch):
    path = tmp_path / "state.ckpt"
    draw = round_scheduler.RoundScheduler.draw

    def later(self, estimate, *rest):
        if estimate.drawn().sum() > 128 * 96 * 16:
            made_of = {**self.settings.made_of, "tracer": "0.0"}
            self.settings = round_scheduler.replace(self.settings, made_of=made_of)
        return draw(self, estimate, *rest)

    monkeypatch.setattr(round_scheduler.RoundScheduler, "draw", later)
    with pytest.raises(ClusterError, match=r"has tracer 0.* has [0-9.]+ % of the samples"):
        tracer.render(SCENE, cluster=two_workers, checkpoint=path, **SETTINGS)
    same(tracer.render(SCENE, checkpoint=path, resume=True, **SETTINGS), alone)


def test_what_crashes_every_worker_is_a_sentence(monkeypatch):
    monkeypatch.setattr(messages, "draw_unit", crash)
    with own_cluster(2) as cluster, connected(cluster) as client, pytest.raises(ClusterError, match="Workers died"):
        tracer.render(SCENE, cluster=client, **SETTINGS)


def crash(*arguments, **keywords):
    os.abort()
