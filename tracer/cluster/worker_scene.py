"""What a worker keeps open between units: a scene, its kernels, and the one thread that uses them."""

from __future__ import annotations

import atexit
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import drjit as dr
import numpy as np

from tracer import criteria
from tracer.cluster.bundle import SCENES
from tracer.cluster.worker_setup import Setup
from tracer.core import backend
from tracer.errors import SceneMissingError
from tracer.film.estimate import Estimate
from tracer.guiding.table import LightChances
from tracer.scene.fingerprint import fingerprint
from tracer.scene.frame import PlainFrame
from tracer.scene.view import open_scene
from tracer.session.guidance import choose_by, guided_view, is_guided
from tracer.session.local_drawer import LocalDrawer

DEVICE = ThreadPoolExecutor(1, "tracer-device")
"""The thread that uses the device. If Dask gives a worker several units at a time, they take turns in this thread, each
with all of Dr.Jit's threads."""
THREADS = "threads"
"""Name of the Dask resource that says how many threads a worker draws with."""
Place = tuple[Path, int]
"""Local folder of a worker, and the number of threads that it draws with."""


class WorkerScene:
    """A scene that a worker has open, and the drawers for it."""

    current: WorkerScene | None = None
    """The scene that is open. There is one at a time: scenes are large, and each slows down the others."""

    def __init__(self, setup: Setup, folder: Path, threads: int) -> None:
        """``folder``: local folder of the worker; ``threads``: number of threads that it may use.

        Raises the errors of ``find_scene`` and ``open_scene``.
        """
        backend.activate(setup.variant)
        dr.set_thread_count(threads)
        self.setup = setup
        self.stack = ExitStack()
        define = dict(setup.define)
        source = find_scene(setup, folder)
        opened = open_scene(source, setup.sensor, setup.integrator, setup.size, setup.crop, define)
        self.plain_view = self.view = self.stack.enter_context(opened)
        self.drawers: dict[str | None, LocalDrawer] = {}
        self.is_guided = is_guided(self.view)
        """Whether the integrator is ``guided``: the scene's own one, or in place of ``path``."""
        self.learned: dict[str, Any] | None = None
        """Chances of lights by which the integrator chooses, as they came."""

    def guide(self, guided: bool, learned: dict[str, Any] | None) -> None:
        """Let the integrator be ``guided`` or not, and choose lights by packed chances; None: all are alike."""
        if guided != self.is_guided:
            self.close_drawers()
            self.view = guided_view(self.plain_view) if guided else self.plain_view
            self.is_guided, self.learned = guided, None
            choose_by(self.view, None)  # an earlier render may have left what it has learned
        if guided and not same_arrays(learned, self.learned):
            choose_by(self.view, None if learned is None else LightChances.unpack(learned))
            self.learned = learned

    def drawer(self, criterion: str | None) -> LocalDrawer:
        """Return the drawer that gathers the moments of a criterion; None: no moments."""
        if criterion not in self.drawers:
            moments = None if criterion is None else criteria.get(criterion).moments
            self.drawers[criterion] = LocalDrawer(self.view, moments)
        return self.drawers[criterion]

    def strip(self, size: int, kinds: tuple[int, int]) -> Estimate:
        """Return an estimate of ``size`` pixels in a row without samples; ``kinds``: numbers of moments and peaks."""
        frame = PlainFrame((1, size), 0, list(self.view.channels), self.view.reach, (0, 0, size, 1))
        return Estimate(frame, *kinds, rfilter=self.view.film.rfilter())

    def close_drawers(self) -> None:
        """Close all drawers."""
        while self.drawers:
            self.drawers.popitem()[1].close()

    def close(self) -> None:
        """Close the drawers and the scene."""
        self.close_drawers()
        self.stack.close()


def same_arrays(first: dict[str, Any] | None, second: dict[str, Any] | None) -> bool:
    """Return whether two sets of arrays are equal, or both None."""
    if first is None or second is None:
        return first is second
    return all(np.array_equal(first[name], second[name]) for name in first)


def place_of(worker: Any) -> Place:
    """Return the local folder and the threads of a Dask worker: its resource THREADS, or else its Dask threads."""
    threads = worker.state.total_resources.get(THREADS, worker.state.nthreads)
    return Path(worker.local_directory), int(threads)


def open_worker_scene(setup: Setup, folder: Path, threads: int) -> WorkerScene:
    """Return the scene of a setup, and open it if it is not; any other scene is closed. Call this on DEVICE only."""
    if WorkerScene.current is None or WorkerScene.current.setup != setup:
        close_worker_scene()
        WorkerScene.current = WorkerScene(setup, folder, threads)
    return WorkerScene.current


@atexit.register
def close_worker_scene() -> None:
    """Close the scene that is open; at exit this happens before Mitsuba is unloaded."""
    if WorkerScene.current is not None:
        WorkerScene.current.close()
        WorkerScene.current = None


def find_scene(setup: Setup, folder: Path) -> Path:
    """Return the scene file of a setup: in a shared folder, or from a bundle. Raises SceneMissingError without one."""
    define: dict[str, Any] = dict(setup.define)
    shared = Path(setup.scene)
    if shared.is_file() and fingerprint(shared, define) == setup.scene_hash:
        return shared
    for unpacked in sorted((folder / SCENES / setup.scene_hash).glob("**/" + shared.name)):
        if fingerprint(unpacked, define) == setup.scene_hash:
            return unpacked
    raise SceneMissingError(f"A worker has no scene '{setup.scene}' as the client has it.")
