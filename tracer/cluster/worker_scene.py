"""What a worker keeps open between units: a scene, its kernels, and the one thread that they are used from."""

from __future__ import annotations

import atexit
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import drjit as dr

from tracer import criteria
from tracer.cluster.bundle import SCENES
from tracer.cluster.worker_setup import Setup
from tracer.core import backend
from tracer.errors import SceneMissingError
from tracer.film.estimate import Estimate
from tracer.sampling.samples import make_sampler
from tracer.scene.fingerprint import fingerprint
from tracer.scene.frame import PlainFrame
from tracer.scene.view import open_scene
from tracer.session.local_drawer import LocalDrawer

DEVICE = ThreadPoolExecutor(1, "tracer-device")
"""A worker may run several units at a time; they take turns here, each with all of its threads."""
THREADS = "threads"
Place = tuple[Path, int]
"""Folder of a worker, and threads that it draws with."""


class WorkerScene:
    """A scene that a worker has open, and who draws it."""

    current: WorkerScene | None = None
    """The one that was used last. One at a time: scenes are large, and each slows down the others."""

    def __init__(self, setup: Setup, folder: Path, threads: int) -> None:
        """``folder``: of the worker; ``threads``: how many it may use. Raises the errors of ``open_scene``."""
        backend.activate(setup.variant)
        dr.set_thread_count(threads)
        self.setup = setup
        self.stack = ExitStack()
        define = dict(setup.define)
        source = find_scene(setup, folder)
        opened = open_scene(source, setup.sensor, setup.integrator, setup.size, setup.crop, define)
        self.view = self.stack.enter_context(opened)
        self.drawers: dict[str | None, LocalDrawer] = {}

    def drawer(self, criterion: str | None) -> LocalDrawer:
        """Return who draws, and gathers the moments of a criterion."""
        if criterion not in self.drawers:
            moments = None if criterion is None else criteria.get(criterion).moments
            self.drawers[criterion] = LocalDrawer(self.view, make_sampler(), moments)
        return self.drawers[criterion]

    def strip(self, size: int, kinds: tuple[int, int]) -> Estimate:
        """Return an estimate of ``size`` consecutive pixels, without samples."""
        frame = PlainFrame((1, size), 0, list(self.view.channels), self.view.reach, (0, 0, size, 1))
        return Estimate(frame, *kinds, rfilter=self.view.film.rfilter())

    def close(self) -> None:
        """Let go of the scene."""
        for drawer in self.drawers.values():
            drawer.close()
        self.stack.close()


def place_of(worker: Any) -> Place:
    """Return folder and threads of a worker: as many as Dask has there, if no resource of the name THREADS says."""
    threads = worker.state.total_resources.get(THREADS, worker.state.nthreads)
    return Path(worker.local_directory), int(threads)


def open_worker_scene(setup: Setup, folder: Path, threads: int) -> WorkerScene:
    """Return the open scene of a setup, in place of any other. Call it on DEVICE only."""
    if WorkerScene.current is None or WorkerScene.current.setup != setup:
        close_worker_scene()
        WorkerScene.current = WorkerScene(setup, folder, threads)
    return WorkerScene.current


@atexit.register
def close_worker_scene() -> None:
    """Let go of the scene that is open, while Mitsuba is still there."""
    if WorkerScene.current is not None:
        WorkerScene.current.close()
        WorkerScene.current = None


def find_scene(setup: Setup, folder: Path) -> Path:
    """Return where this worker has the scene. Raises SceneMissingError if it does not have it."""
    define: dict[str, Any] = dict(setup.define)
    shared = Path(setup.scene)
    if shared.is_file() and fingerprint(shared, define) == setup.scene_hash:
        return shared
    for unpacked in sorted((folder / SCENES / setup.scene_hash).glob("**/" + shared.name)):
        if fingerprint(unpacked, define) == setup.scene_hash:
            return unpacked
    raise SceneMissingError(f"A worker has no scene '{setup.scene}' as the client has it.")
