"""Render the cells of a scene on workers: blocks of the same budget and seed, each by one, so that times compare.

Cells that are rendered at once on one machine share it: their times are those of a machine that has other things to do.
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
from tracer.study.cells import Cell, is_kept, machine, store
from tracer.study.methods import Shot, Studio
from tracer.study.plan import Plan, Scene, import_criteria
from tracer.study.records import Failure
from tracer.study.render_cells import CellCallback, Opened, failure

TICK = 0.1
"""Seconds after which it is looked what is done, and a person is heard."""
MOST_TRIES = 3
Made = list[tuple[Cell, tuple[Shot, int, str] | Failure]]
"""Cells, and their pictures with samples per pixel and machine, or why there is none."""


def shoot(
    plan: Plan,
    scene: Scene,
    blocks: list[list[Cell]],
    output: Path,
    run: str,
    told: CellCallback,
    connection: Connection,
) -> list[Failure]:
    """Render what is missing on workers; return what could not be rendered. Raises ClusterError."""
    missing = [[cell for cell in block if not is_kept(cell, output)] for block in blocks]
    missing = [block for block in missing if block]
    if not missing:
        return []
    setting = scene.setting
    try:
        seen = {"integrator": setting.integrator, "size": setting.size}
        setup = make_setup(setting.source, fingerprint(setting.source), mi.variant(), None, setting.sensor, **seen)
    except Exception as error:  # whatever it is, the other scenes can still be measured
        return [failure(cell, error) for block in missing for cell in block]
    failures: list[Failure] = []
    told(None, f"{scene.name}: opening on workers")
    for made in made_elsewhere(connection, plan, scene, setup, missing, told):
        for cell, outcome in made:
            if isinstance(outcome, Failure):
                failures.append(outcome)
            else:
                shot, spp, where = outcome
                store(cell, output, shot, spp, run, where)
            told(cell, f"{scene.name}: {cell.method}, {cell.budget.label}, seed {cell.seed}")
    return failures


def made_elsewhere(
    connection: Connection, plan: Plan, scene: Scene, setup: Setup, blocks: list[list[Cell]], told: CellCallback
) -> Iterator[Made]:
    """Yield blocks as they are made. Raises ClusterError, and KeyboardInterrupt if ``told`` does."""
    client, messages, shipped, tries = connection.client, Messages(connection), False, 0

    def ask(block: list[Cell]) -> Any:
        return client.submit(shoot_block, plan, scene, setup, software(), block, pure=False)

    waiting = {ask(block): block for block in blocks}
    try:
        while waiting:
            told(None, "")
            messages.require_scheduler()
            time.sleep(TICK)
            for future in [each for each in waiting if each.done()]:
                block = waiting.pop(future)
                error = None if future.status == "finished" else future.exception() or CancelledError(future.key)
                if isinstance(error, SceneMissingError) and tries < MOST_TRIES * len(blocks):
                    tries += 1
                    if not shipped:
                        connection.ship(setup)
                        shipped = True
                    waiting[ask(block)] = block
                elif isinstance(error, KilledWorker):
                    yield [(cell, failure(cell, Exception(str(explained(error))))) for cell in block]
                elif error is not None:
                    raise explained(error)
                else:
                    yield future.result()
    except UNANSWERED:
        raise ClusterError(
            f"The scheduler {connection.address} is gone; what is done is kept, run the same again."
        ) from None
    finally:
        messages.cancel(list(waiting))


def shoot_block(plan: Plan, scene: Scene, setup: Setup, made_of: dict[str, str], block: list[Cell]) -> Made:
    """Render a block on a worker."""
    worker = get_worker()
    require_same(software(), made_of, worker.address)
    place = place_of(worker)
    return DEVICE.submit(shoot_on_device, plan, scene, setup, place, block).result()


def shoot_on_device(plan: Plan, scene: Scene, setup: Setup, place: Place, block: list[Cell]) -> Made:
    """Do the work of ``shoot_block``; ``place``: folder and threads of the worker."""
    theatre = Theatre.of(plan, scene, setup, place)
    made: Made = []
    for cell in block:
        try:
            shot, spp = theatre.opened(cell).shoot(cell)
            made.append((cell, (shot, spp, machine())))
        except Exception as error:  # told as a failure, as where the client draws
            made.append((cell, failure(cell, error)))
    return made


class Theatre:
    """A scene open on a worker for all methods, and what was found out about them."""

    current: Theatre | None = None

    def __init__(self, plan: Plan, scene: Scene, setup: Setup, place: Place) -> None:
        backend.activate(setup.variant)
        dr.set_thread_count(place[1])
        import_criteria(plan)
        self.key = (plan.model_dump_json(), setup)
        self.plan = plan
        self.setting = replace(scene.setting, source=find_scene(setup, place[0]))
        self.stack = ExitStack()
        samplers = [one.sampler for one in plan.methods if one.sampler is not None]
        self.studio = Studio(self.stack, self.setting, samplers)
        self.methods: dict[str, Opened] = {}

    @classmethod
    def of(cls, plan: Plan, scene: Scene, setup: Setup, place: Place) -> Theatre:
        """Return the one of a scene, in place of any other that is open."""
        if cls.current is None or cls.current.key != (plan.model_dump_json(), setup):
            close_worker_scene()
            close_theatre()
            cls.current = cls(plan, scene, setup, place)
        return cls.current

    def opened(self, cell: Cell) -> Opened:
        """Return the method of a cell, all of its kernels compiled."""
        if cell.method not in self.methods:
            method = next(one for one in self.plan.methods if one.name == cell.method)
            opened = Opened(self.studio, method, self.setting, lambda cell, text: None)
            opened.prepare(set(self.plan.budgets))
            self.methods[cell.method] = opened
        return self.methods[cell.method]


@atexit.register
def close_theatre() -> None:
    """Let go of the scene that is open, while Mitsuba is still there."""
    if Theatre.current is not None:
        Theatre.current.stack.close()
        Theatre.current = None
