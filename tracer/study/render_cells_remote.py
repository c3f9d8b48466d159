"""Render the cells of a scene on workers; one worker renders all cells of a block, so that their times compare.

A block is all cells of the same budget and seed. Blocks that are rendered at once on one machine slow each other down.
"""

from __future__ import annotations

import atexit
import time
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
from distributed import CancelledError, KilledWorker, get_worker

from tracer.cluster.connection import Connection
from tracer.cluster.messages import UNANSWERED, Messages, explained
from tracer.cluster.worker_scene import DEVICE, Place, close_worker_scene, find_scene, place_of
from tracer.cluster.worker_setup import Setup, make_setup, require_same, software
from tracer.core import backend
from tracer.errors import ClusterError, SceneMissingError
from tracer.scene.fingerprint import fingerprint
from tracer.study.cells import Cell, machine, store
from tracer.study.methods import Studio, TimedPicture
from tracer.study.plan import Plan, Scene, import_criteria
from tracer.study.records import Failure
from tracer.study.render_cells import CellCallback, Opened, failure

TICK = 0.1
"""Seconds between two looks at which blocks are done and whether the study is to stop."""
MOST_TRIES = 3
"""Most times, per block, that blocks are sent again because a worker lacks the scene."""
Made = list[tuple[Cell, tuple[TimedPicture, int, str] | Failure]]
"""Cells, each with its picture, samples per pixel and machine, or with its failure."""


def render_cells(
    plan: Plan,
    scene: Scene,
    blocks: list[list[Cell]],
    output: Path,
    run: str,
    notify: CellCallback,
    connection: Connection,
) -> list[Failure]:
    """Render cells on workers; return those that failed. Raises ClusterError."""
    setting = scene.setting
    try:
        keywords = {"integrator": setting.integrator, "size": setting.size}
        setup = make_setup(setting.source, fingerprint(setting.source), mi.variant(), None, setting.sensor, **keywords)
    except Exception as error:  # whatever it is, the other scenes can still be measured
        return [failure(cell, error) for block in blocks for cell in block]
    failures: list[Failure] = []
    notify(None, f"{scene.name}: opening on workers")
    for made in made_elsewhere(connection, plan, scene, setup, blocks, notify):
        for cell, outcome in made:
            if isinstance(outcome, Failure):
                failures.append(outcome)
            else:
                picture, spp, where = outcome
                store(cell, output, picture, spp, run, where)
            notify(cell, f"{scene.name}: {cell.method}, {cell.budget.label}, seed {cell.seed}")
    return failures


def made_elsewhere(
    connection: Connection, plan: Plan, scene: Scene, setup: Setup, blocks: list[list[Cell]], notify: CellCallback
) -> Iterator[Made]:
    """Yield blocks as workers finish them. Raises ClusterError, and KeyboardInterrupt if ``notify`` does."""
    client, messages, shipped, tries = connection.client, Messages(connection), False, 0

    def submit(block: list[Cell]) -> Any:
        return client.submit(render_block, plan, scene, setup, software(), block, pure=False)

    waiting = {submit(block): block for block in blocks}
    try:
        while waiting:
            notify(None, "")
            messages.require_scheduler()
            time.sleep(TICK)
            for future in [candidate for candidate in waiting if candidate.done()]:
                block = waiting.pop(future)
                error = None if future.status == "finished" else future.exception() or CancelledError(future.key)
                if isinstance(error, SceneMissingError) and tries < MOST_TRIES * len(blocks):
                    tries += 1
                    if not shipped:
                        connection.ship(setup)
                        shipped = True
                    waiting[submit(block)] = block
                elif isinstance(error, KilledWorker):
                    yield [(cell, failure(cell, Exception(str(explained(error))))) for cell in block]
                elif error is not None:
                    raise explained(error)
                else:
                    yield future.result()
    except UNANSWERED:
        raise ClusterError(
            f"The scheduler {connection.address} is gone; all finished cells are kept, so run the study again."
        ) from None
    finally:
        messages.cancel(list(waiting))


def render_block(plan: Plan, scene: Scene, setup: Setup, client_software: dict[str, str], block: list[Cell]) -> Made:
    """Render a block on a worker whose software must be that of the client."""
    worker = get_worker()
    require_same(software(), client_software, worker.address)
    place = place_of(worker)
    return DEVICE.submit(render_on_device, plan, scene, setup, place, block).result()


def render_on_device(plan: Plan, scene: Scene, setup: Setup, place: Place, block: list[Cell]) -> Made:
    """Render a block while no other block is rendered on this worker; ``place``: its folder and number of threads."""
    theatre = Theatre.of(plan, scene, setup, place)
    made: Made = []
    for cell in block:
        try:
            picture, spp = theatre.opened(cell).render(cell)
            made.append((cell, (picture, spp, machine())))
        except Exception as error:  # reported as a failure, as it is without workers
            made.append((cell, failure(cell, error)))
    return made


class Theatre:
    """A scene that is open on a worker, and its methods, prepared when first needed."""

    current: Theatre | None = None
    """The one scene that is open on this worker."""

    def __init__(self, plan: Plan, scene: Scene, setup: Setup, place: Place) -> None:
        backend.activate(setup.variant)
        dr.set_thread_count(place[1])
        import_criteria(plan)
        self.key = (plan.model_dump_json(), setup)
        self.plan = plan
        self.setting = replace(scene.setting, source=find_scene(setup, place[0]))
        self.stack = ExitStack()
        samplers = [method.sampler for method in plan.methods if method.sampler is not None]
        self.studio = Studio(self.stack, self.setting, samplers)
        self.methods: dict[str, Opened] = {}

    @classmethod
    def of(cls, plan: Plan, scene: Scene, setup: Setup, place: Place) -> Theatre:
        """Return the theatre of a scene; one of another scene is closed first."""
        if cls.current is None or cls.current.key != (plan.model_dump_json(), setup):
            close_worker_scene()
            close_theatre()
            cls.current = cls(plan, scene, setup, place)
        return cls.current

    def opened(self, cell: Cell) -> Opened:
        """Return the method of a cell, with all of its kernels compiled."""
        if cell.method not in self.methods:
            method = next(method for method in self.plan.methods if method.name == cell.method)
            opened = Opened(self.studio, method, self.setting, lambda cell, text: None)
            opened.prepare(set(self.plan.budgets))
            self.methods[cell.method] = opened
        return self.methods[cell.method]


@atexit.register
def close_theatre() -> None:
    """Release the scene that is open, before Mitsuba is unloaded."""
    if Theatre.current is not None:
        Theatre.current.stack.close()
        Theatre.current = None
