"""Cells of a study: one picture each, kept in a file with what it took, so that nothing is rendered twice."""

from __future__ import annotations

import hashlib
import itertools
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from tracer.core import backend
from tracer.errors import OutputError
from tracer.io import exr
from tracer.scene.fingerprint import fingerprint
from tracer.study import source_hash
from tracer.study.methods import Shot
from tracer.study.plan import Budget, MethodPlan, Plan, Scene

FOLDER = "cells"


@dataclass(frozen=True)
class Cell:
    """One picture that a study asks for."""

    scene: str
    method: str
    budget: Budget
    seed: int
    key: str
    """Hash of all that its pixels depend on."""

    def path(self, output: Path) -> Path:
        """Return the file it is kept in."""
        return output / FOLDER / self.scene / self.method / f"{self.budget.label}, seed {self.seed}.exr"


@dataclass(frozen=True)
class Took:
    """What a picture took, beside its pixels."""

    spp: int
    """Samples per pixel that were asked for."""
    samples: int
    seconds: float
    seconds_drawing: float
    run: str
    """Which run of the program made it: times within a run and seed are paired."""
    machine: str
    """On what it ran: processor and threads."""


def cells_of(plan: Plan, place: Scene) -> list[list[Cell]]:
    """Return the cells of a scene in blocks of the same budget and seed, which are rendered one after the other.

    From block to block the methods take turns in being first, so that none has the cold machine every time.
    """
    setting = place.setting
    content = (fingerprint(setting.source), setting.sensor, setting.integrator, setting.size)
    blocks = []
    for k, (budget, seed) in enumerate(itertools.product(plan.budgets, plan.all_seeds)):
        turn = k % len(plan.methods)
        block = [
            Cell(place.name, method.name, budget, seed, key(content, method, budget, seed))
            for method in [*plan.methods[turn:], *plan.methods[:turn]]
        ]
        blocks.append(block)
    return blocks


def key(content: tuple[Any, ...], method: MethodPlan, budget: Budget, seed: int) -> str:
    """Return the hash of all that the pixels of a cell depend on, the code included."""
    made_by = source_hash.stock_hash() if method.sampler else source_hash.render_hash()
    own = (
        source_hash.criterion_hash(method.criterion)
        if method.criterion
        else source_hash.oracle_hash()
        if method.oracle
        else ""
    )
    settings = method.model_dump_json(exclude={"name", "objective"} if method.sampler else {"name"})
    parts = (content, settings, budget, seed, made_by, own, mi.__version__, mi.variant())
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:24]


def store(cell: Cell, output: Path, shot: Shot, spp: int, run: str, where: str | None = None) -> None:
    """Keep a picture; ``where``: on which machine it was made, if not on this one."""
    path = cell.path(output)
    path.parent.mkdir(parents=True, exist_ok=True)
    took = Took(spp, shot.samples, shot.seconds, shot.seconds_drawing, run, where or machine())
    values = np.concatenate([shot.image, shot.counts[..., None]], axis=-1, dtype=np.float32)
    exr.write_exr(path, ["R", "G", "B", "samples.Y"], values, {"key": cell.key, "took": asdict(took)})


def machine() -> str:
    """Return processor and threads."""
    return f"{backend.processor()}, {backend.thread_count()} threads"


def is_kept(cell: Cell, output: Path) -> bool:
    """Return whether the picture of a cell is there, made from what it would be made from now."""
    path = cell.path(output)
    try:
        return path.exists() and exr.read_metadata(path).get("key") == cell.key
    except OutputError:  # damaged: it is made again and takes its place
        return False


def load(cell: Cell, output: Path) -> tuple[Shot, Took]:
    """Return a picture that was kept. Raises OutputError if it cannot be read."""
    names, values, own = exr.read_exr(cell.path(output))
    took = Took(**json.loads(own["took"]))
    colours = [names.index(name) for name in "RGB"]
    counts = values[..., names.index("samples.Y")]
    return Shot(values[..., colours], counts, took.samples, took.seconds, took.seconds_drawing), took
