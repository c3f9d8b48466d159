"""What guiding could gain at best in a scene: where its noise comes from.

A few million paths of every scene tell what each choice along them has given: of a light, or of a part of a large one,
of a direction after the first and second vertex, and to go on at all. One half of the paths teaches the best chances in
cells of space, the other half judges them. Of scenes with rectangular lights, pictures of their direct light tell what
other places on these lights would gain. Floors under ten to ten thousand lights tell whether their number costs time.
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
from benchmarks.guiding.light_counts import COUNTS, KINDS, light_count_rows, light_counts_in_words
from benchmarks.guiding.limits import limits, roulette_limit, weights_of
from benchmarks.guiding.paths import follow
from benchmarks.guiding.rectangles import SEEDS as PICTURES
from benchmarks.guiding.rectangles import SPP, WAYS, Gains, Lights, gains
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


RECTANGLE_SIZE, RECTANGLE_SEED = 96, 960
"""Width in pixels of the pictures of direct light, and the first seed of them."""
NOISE, RECTANGLES, LIGHT_COUNTS = "noise", "rectangles", "light counts"
"""Names of the parts of the results."""


@dataclass(frozen=True)
class Row:
    """Results of a scene."""

    scene: str
    slots: int
    """Number of lights, parts of lights or groups of lights that can be chosen among."""
    factors: dict[str, list[float]]
    """For each of ``COLUMNS``, the factor by which the variance falls, one for each seed."""


def report(folder: Path, progress: StepCallback, public: Path, resume: bool = False) -> None:
    """Measure all scenes, and write ``FILES`` after every scene, so that a run that is stopped keeps its results.

    ``public``: folder with folders that have a scene.xml; ``resume``: keep the rows that ``folder`` has. Raises
    KeyboardInterrupt if ``progress`` stops it.
    """
    scenes = openers(public)
    announce = harness.StepCounter(progress, 2 * len(scenes) + len(KINDS) * (len(COUNTS) + 1))
    kept = harness.measured_before(folder, resume)
    parts = (NOISE, RECTANGLES, LIGHT_COUNTS)
    numbers: dict[str, list[dict[str, Any]]] = {part: kept.get(part, []) for part in parts}
    for part, function in ((NOISE, measure), (RECTANGLES, measure_rectangles)):
        known = {row["scene"] for row in numbers[part]}
        for name, opener in scenes.items():
            announce(f"{name}: {part}")
            row = None if name in known else function(name, opener())
            if row is not None:
                numbers[part].append(asdict(row))
                harness.write(folder, numbers, to_page(numbers))
    known = {row["kind"] for row in numbers[LIGHT_COUNTS]}
    for kind in KINDS:
        if kind not in known:
            numbers[LIGHT_COUNTS] += map(asdict, light_count_rows(kind, announce))
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


@dataclass(frozen=True)
class RectangleRow:
    """Results of a scene with rectangular lights."""

    scene: str
    rectangles: int
    """Number of rectangular lights."""
    gains: Gains


def measure_rectangles(name: str, scene: Any) -> RectangleRow | None:
    """Return the results of a scene, or None if no light is a rectangle or its integrator is not ``path``."""
    with open_scene(scene, 0, None, RECTANGLE_SIZE) as view:
        if view.integrator.class_name() != "PathIntegrator":
            return None
        lights = Lights.of(view.scene)
        if lights.rectangle_count == 0:
            return None
        return RectangleRow(name, lights.rectangle_count, gains(view, lights, RECTANGLE_SEED))


def to_page(numbers: dict[str, list[dict[str, Any]]]) -> str:
    """Return the results as Markdown."""
    introduction = (
        f"{harness.written_by('guiding PUBLIC')}: {SIZE} pixels wide, {PATHS} paths, mean of seeds "
        f"{' and '.join(map(str, SEEDS))}. By which factor the variance of single paths would fall (weighted as relMSE "
        "weights it) with the best chances that one half of the paths teaches in "
        "cells of space, as the other half judges them; where a cell is not sure to gain, Mitsuba's own choice stays. "
        "Roulette: variance times number of vertices, if paths ended at the best chance of each depth."
    )
    rows = [Row(**row) for row in numbers[NOISE]]
    cells = [[row.scene, str(row.slots), *(f"{np.mean(row.factors[name]):.2f}" for name in COLUMNS)] for row in rows]
    logs = [[float(np.log(np.mean(row.factors[name]))) for name in COLUMNS] for row in rows]
    means = ["**geometric mean**", "", *(f"**{value:.2f}**" for value in np.exp(np.mean(logs, axis=0)))]
    return harness.page(
        "Guiding: where noise comes from",
        f"{introduction}\n\n{markdown_table(HEADINGS, [*cells, means])}",
        {
            "Places on rectangular lights": rectangles_in_words(numbers[RECTANGLES]),
            "Numbers of lights": light_counts_in_words(numbers[LIGHT_COUNTS]),
        },
    )


def rectangles_in_words(rows: list[dict[str, Any]]) -> str:
    """Return the section on rectangular lights as Markdown."""
    introduction = (
        "Mitsuba chooses places on rectangles by area, on spheres by solid angle. By which factor the variance of "
        f"direct light (by shadow rays and by the material, {RECTANGLE_SIZE} pixels wide, {PICTURES} pictures, "
        "weighted as relMSE weights it) would fall with places chosen by solid angle, or nearly by the cosine at the "
        "lit surface; "
        "how many times as long the kernels of direct light take; and the gain at equal time, with the most samples."
    )
    by_spp = [f"{way}, {spp} spp" for way in WAYS[1:] for spp in SPP]
    headings = ["scene", "rectangles", *by_spp, *(f"{way}, {what}" for what in ("time", "gain") for way in WAYS[1:])]
    cells = []
    for row in rows:
        variance, time = row["gains"]["variance"], row["gains"]["time"]
        values = [value for way in WAYS[1:] for value in variance[way]]
        values += [time[way] for way in WAYS[1:]] + [variance[way][-1] / time[way] for way in WAYS[1:]]
        cells.append([row["scene"], str(row["rectangles"]), *(f"{value:.2f}" for value in values)])
    return f"{introduction}\n\n{markdown_table(headings, cells)}"
