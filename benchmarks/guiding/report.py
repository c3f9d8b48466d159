"""What guiding could gain at best in a scene: where its noise comes from.

A few million paths of every scene tell what each choice along them has given: of a light, or of a part of a large one,
of a direction after the first and second vertex, and to go on at all. One half of the paths teaches the best chances in
cells of space, the other half judges them.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import harness
from benchmarks.guiding.limits import limits, roulette_limit, weights_of
from benchmarks.guiding.paths import follow
from tracer.guiding.slots import slots_of
from tracer.progress import StepCallback
from tracer.scene.load import load
from tracer.scene.view import open_scene
from tracer.session.guidance import guided_view
from tracer.study.tables import markdown_table

logger = logging.getLogger(__name__)
FILES = (harness.PAGE, harness.NUMBERS)
"""Names of the files that this benchmark writes."""
SIZE, PATHS, SEEDS = 192, 1 << 20, (950, 951)
"""Width of the pictures in pixels, and paths of each seed."""
HEADINGS = (
    "scene",
    "slots",
    "lights",
    "lights and parts",
    "directions, 1st vertex",
    "directions, 2nd vertex",
    "all three",
    "roulette by depth",
)
"""Headings of the columns of the table."""
COLUMNS = ("lights", "parts", "directions 1", "directions 2", "all", "roulette")
"""Names of the factors, in the order of the table."""


@dataclass(frozen=True)
class Row:
    """Results of a scene."""

    scene: str
    slots: int
    """Number of lights, parts of lights or groups of lights that can be chosen among."""
    factors: dict[str, list[float]]
    """For each of ``COLUMNS``, the factor by which the variance falls, one for each seed."""


def report(folder: Path, progress: StepCallback, public: Path) -> None:
    """Measure all scenes, and write ``FILES`` after every scene, so that a run that is stopped keeps its results.

    ``public``: folder with folders that have a scene.xml. Raises KeyboardInterrupt if ``progress`` stops it.
    """
    scenes = openers(public)
    announce = harness.StepCounter(progress, len(scenes))
    rows: list[Row] = []
    for name, opener in scenes.items():
        announce(name)
        row = measure(name, opener())
        if row is not None:
            rows.append(row)
        numbers = [asdict(measured) for measured in rows]
        harness.write(folder, numbers, to_page(numbers))


def openers(public: Path) -> dict[str, Callable[[], Any]]:
    """Return a function for each scene that opens it."""
    theirs = {path.parent.name: path for path in sorted(public.glob("*/scene.xml"))}
    ours = {path.stem: path for path in harness.bundled_scenes()}
    return {name: partial(load, path) for name, path in {**ours, **theirs}.items()}


def measure(name: str, scene: Any) -> Row | None:
    """Return the results of a scene, or None if its integrator is not ``path``."""
    with open_scene(scene, 0, None, SIZE) as opened:
        if opened.integrator.class_name() != "PathIntegrator":
            logger.warning("%s is left out, as its integrator is not 'path'", name)
            return None
        view = guided_view(opened)
        plan = slots_of(view.scene)
        factors: dict[str, list[float]] = {column: [] for column in COLUMNS}
        for seed in SEEDS:
            choices = follow(view, plan, seed, PATHS)
            found = limits(choices, view.grid, plan)
            found["roulette"] = roulette_limit(choices.steps, weights_of(choices.paths, view.grid), choices.costs)
            for column in COLUMNS:
                factors[column].append(found[column])
    return Row(name, len(plan.stock), factors)


def to_page(numbers: list[dict[str, Any]]) -> str:
    """Return the results as Markdown."""
    introduction = (
        f"{harness.written_by('guiding PUBLIC')}: {SIZE} pixels wide, {PATHS} paths, mean of seeds "
        f"{' and '.join(map(str, SEEDS))}. By which factor the variance of single paths would fall (weighted as relMSE "
        "weights it) with the best chances that one half of the paths teaches in "
        "cells of space, as the other half judges them; where a cell is not sure to gain, Mitsuba's own choice stays. "
        "Roulette: variance times number of vertices, if paths ended at the best chance of each depth."
    )
    rows = [Row(**row) for row in numbers]
    cells = [[row.scene, str(row.slots), *(f"{np.mean(row.factors[name]):.2f}" for name in COLUMNS)] for row in rows]
    logs = [[float(np.log(np.mean(row.factors[name]))) for name in COLUMNS] for row in rows]
    means = ["**geometric mean**", "", *(f"**{value:.2f}**" for value in np.exp(np.mean(logs, axis=0)))]
    return harness.page(
        "Guiding: where noise comes from", f"{introduction}\n\n{markdown_table(HEADINGS, [*cells, means])}", {}
    )
