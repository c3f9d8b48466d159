"""Workers open a scene and compile what it needs while the client does so itself."""

import logging
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from dask.distributed import get_worker

from tracer import scenes
from tracer.cluster import connection
from tracer.cluster.connection import Connection
from tracer.cluster.remote_drawer import open_workers
from tracer.errors import SceneMissingError
from tracer.scene.fingerprint import fingerprint
from tracer.session.request import Request

SCENE = Path(scenes.__file__).parent / "spheres_and_rods.xml"
LONGEST = 300
"""Seconds for what takes one or two."""


def kernels():
    """Return, on a worker, the scene that is open and how often it was traced for drawing."""
    from tracer.cluster.worker_scene import WorkerScene

    if WorkerScene.current is None:
        return None
    drawers = WorkerScene.current.drawers.values()
    return WorkerScene.current.setup.scene_hash, [drawer.record.record.n_recordings for drawer in drawers]


def test_workers_are_warm_before_there_is_a_unit(two_workers):
    scene_hash = fingerprint(SCENE)
    with open_workers(two_workers) as workers:
        workers(Request(SCENE, size=19), scene_hash)
        deadline = time.monotonic() + LONGEST
        while not all(is_warm(found, scene_hash) for found in two_workers.run(kernels).values()):
            assert time.monotonic() < deadline
            time.sleep(0.1)


def is_warm(found, scene_hash):
    """Return whether a worker has this scene open, and has traced it."""
    return found is not None and found[0] == scene_hash and bool(found[1]) and found[1][0] > 0


def fail(setup):
    raise ValueError(f"there is no room on {get_worker().address}")


def miss(setup):
    raise SceneMissingError("not here")


@pytest.mark.parametrize(("work", "messages"), [(fail, 2), (miss, 0)])
def test_what_goes_wrong_is_logged_unless_the_first_unit_raises_it(two_workers, monkeypatch, caplog, work, messages):
    monkeypatch.setattr(connection, "prepare", work)
    called = []
    log_failure = connection.log_failure
    monkeypatch.setattr(connection, "log_failure", lambda future: (log_failure(future), called.append(future)))
    workers = Connection(two_workers, "")
    with caplog.at_level(logging.WARNING):
        workers.begin(None)
        deadline = time.monotonic() + LONGEST
        while len(called) < 2:
            assert time.monotonic() < deadline
            time.sleep(0.05)
    logged = [record.getMessage() for record in caplog.records if record.name == connection.__name__]
    assert len(set(logged)) == messages
    assert all("ValueError: there is no room on tcp://" in message for message in logged)


def test_a_client_that_cannot_be_closed_does_not_hide_what_happened():
    """Dask itself raises at times where a scheduler is gone: its futures change while it connects anew."""

    def fail(timeout):
        raise RuntimeError("dictionary changed size during iteration")

    connection.close(SimpleNamespace(close=fail))
