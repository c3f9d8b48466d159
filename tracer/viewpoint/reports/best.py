"""Find the best view: its picture, a camera for Mitsuba, and the sphere with the way that the search took."""

from __future__ import annotations

import json
import time
from typing import Literal

import numpy as np

from tracer.core.sphere import icosphere
from tracer.errors import SceneError
from tracer.io import atomic, exr
from tracer.viewpoint import measures, plots
from tracer.viewpoint.camera import write_sensors
from tracer.viewpoint.reports.context import ViewContext, name_direction, number, require_sight
from tracer.viewpoint.search import Found, exhaustive_search, paper_search

FILES = ("best.png", "sphere.png", "camera.xml", "best.json")
"""The report writes files of these names."""
HEADINGS = ("search", "view", "value", "views", "seconds")
"""The columns of the table have these headings."""
Search = Literal["paper", "octants", "exhaustive"]
"""These searches can be chosen by name."""
SEARCHES: tuple[Search, ...] = ("paper", "octants", "exhaustive")
"""These are all searches, in the order of the table."""
SPHERE_LEVEL = 2
"""The measure is drawn on an icosphere of this level."""
PICTURE = 512
"""The picture of the best view has this many pixels along each side."""


def best(
    context: ViewContext, name: str, searches: list[Search], level: int, good: measures.Best | None = None
) -> list[list[str]]:
    """Write ``FILES`` for the best view of all searches, and return the lines of the table under ``HEADINGS``.

    ``good``: whether good views have the most or the least of the measure, see ``ViewContext.gauge``. Raises SceneError
    if no view sees anything, or none has a finite value.
    """
    results: dict[Search, Found] = {}
    lines = []
    gauge = context.gauge(name, good)
    for k, search in enumerate(searches):
        context.say(f"{search} search", k, len(searches) + 1)
        start, evaluations_before = time.perf_counter(), gauge.evaluations

        def value(directions: np.ndarray, done: int = k) -> np.ndarray:
            gauge.progress = lambda *_: context.say(f"{searches[done]} search", done, len(searches) + 1)
            return gauge.better(directions)

        if search == "exhaustive":
            results[search] = exhaustive_search(value, level, context.opened.axes)
        else:
            results[search] = paper_search(value, all_octants=search == "octants")
        result = results[search]
        seconds = time.perf_counter() - start
        shown = number(gauge.sign * result.value)
        place = name_direction(result.direction, context.stand.up)
        lines.append([search, place, shown, str(gauge.evaluations - evaluations_before), f"{seconds:.2f}"])
    winner = max(results.values(), key=lambda result: result.value)
    require_sight(gauge.sighted)
    if not np.isfinite(winner.value):
        raise SceneError(f"No view that was tried has a finite {name}; choose another measure, or the other searches.")
    context.say("pictures", len(searches), len(searches) + 1)
    directions, triangles = icosphere(SPHERE_LEVEL)
    values = gauge(directions)
    marks: dict[str, plots.Mark] = {
        search: plots.Mark(result.direction, gauge.sign * result.value) for search, result in results.items()
    }
    way = np.array([place for place, _ in results[searches[0]].steps])
    plots.sphere_plot(
        context.folder / "sphere.png", [name], directions, triangles, [values], context.stand.up, way, [marks]
    )
    view = context.stand.viewpoints(winner.direction[None])
    exr.write_png(context.folder / "best.png", context.pictures(view, PICTURE)[0])
    write_sensors(context.folder / "camera.xml", view, context.stand.lens, clip=context.stand.clip)
    report = {
        "measure": name,
        "good": "most" if gauge.sign > 0 else "least",
        "direction": winner.direction.tolist(),
        "eye": view.eyes[0].tolist(),
        "target": context.stand.centre.tolist(),
        "origin": list(context.opened.origin),
        "remarks": list(context.opened.remarks),
        "up": view.up[0].tolist(),
        "value": gauge.sign * winner.value,
        "stderr": float(gauge.estimate(view).stderr[0]) if gauge.estimated else None,
        "searches": [dict(zip(HEADINGS, line, strict=True)) for line in lines],
    }
    atomic.write_text(context.folder / "best.json", json.dumps(report, indent=1) + "\n")
    return lines
