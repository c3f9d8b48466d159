"""Cells of a study: each is one picture, kept in a file with what it cost, so that nothing is rendered twice."""

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
from tracer.study.methods import TimedPicture
from tracer.study.plan import Budget, MethodPlan, Plan, Scene

FOLDER = "cells"
"""Name of the folder for the pictures within the folder of a study."""


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
        """Return the file that the picture is kept in; ``output`` is the folder of the study."""
        return output / FOLDER / self.scene / self.method / f"{self.budget.label}, seed {self.seed}.exr"


@dataclass(frozen=True)
class RenderCost:
    """What a picture cost: samples, time, and the machine."""

    spp: int
    """Samples per pixel that were asked for."""
    samples: int
    """Samples that were taken in all."""
    seconds: float
    """Seconds that the picture took."""
    seconds_drawing: float
    """The part of ``seconds`` in which radiance samples were drawn."""
    run: str
    """Identifies the run of the program that made the picture: times within a run and seed are paired."""
    machine: str
    """Processor and threads that rendered the picture."""


def cells_of(plan: Plan, scene: Scene) -> list[list[Cell]]:
    """Return the cells of a scene in blocks of one budget and seed, which are rendered one after the other.

    From block to block the methods take turns in being first, so that no method has the cold machine every time.
    """
    setting = scene.setting
    content = (fingerprint(setting.source), setting.sensor, setting.integrator, setting.size)
    blocks = []
    for k, (budget, seed) in enumerate(itertools.product(plan.budgets, plan.all_seeds)):
        turn = k % len(plan.methods)
        block = [
            Cell(scene.name, method.name, budget, seed, key(content, method, budget, seed))
            for method in [*plan.methods[turn:], *plan.methods[:turn]]
        ]
        blocks.append(block)
    return blocks


def key(content: tuple[Any, ...], method: MethodPlan, budget: Budget, seed: int) -> str:
    """Return the hash of all that the pixels of a cell depend on, the code included."""
    renderer = source_hash.stock_hash() if method.sampler else source_hash.render_hash()
    allocator = (
        source_hash.criterion_hash(method.criterion)
        if method.criterion
        else source_hash.oracle_hash()
        if method.oracle
        else ""
    )
    settings = method.model_dump_json(exclude={"name", "objective"} if method.sampler else {"name"})
    parts = (content, settings, budget, seed, renderer, allocator, mi.__version__, mi.variant())
    return hashlib.sha256(repr(parts).encode()).hexdigest()[:24]


def store(cell: Cell, output: Path, picture: TimedPicture, spp: int, run: str, where: str | None = None) -> None:
    """Keep a picture in its file; ``where``: the machine that made it, if it was not this one."""
    path = cell.path(output)
    path.parent.mkdir(parents=True, exist_ok=True)
    cost = RenderCost(spp, picture.samples, picture.seconds, picture.seconds_drawing, run, where or machine())
    values = np.concatenate([picture.image, picture.counts[..., None]], axis=-1, dtype=np.float32)
    exr.write_exr(path, ["R", "G", "B", "samples.Y"], values, {"key": cell.key, "took": asdict(cost)})


def machine() -> str:
    """Return the name of the processor and the number of threads."""
    return f"{backend.processor()}, {backend.thread_count()} threads"


def is_kept(cell: Cell, output: Path) -> bool:
    """Return whether the picture of a cell is kept, and was made from all that it would be made from now."""
    path = cell.path(output)
    try:
        return path.exists() and exr.read_metadata(path).get("key") == cell.key
    except OutputError:  # a damaged file is made again and replaced
        return False


def load(cell: Cell, output: Path) -> tuple[TimedPicture, RenderCost]:
    """Return the picture that is kept of a cell, and what it cost. Raises OutputError if it cannot be read."""
    names, values, metadata = exr.read_exr(cell.path(output))
    cost = RenderCost(**json.loads(metadata["took"]))
    colours = [names.index(name) for name in "RGB"]
    counts = values[..., names.index("samples.Y")]
    return TimedPicture(values[..., colours], counts, cost.samples, cost.seconds, cost.seconds_drawing), cost
