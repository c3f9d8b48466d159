"""Measure views from all around: a table, a sphere for each measure, and pictures of the best and worst views."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tracer.core.sphere import icosphere, neighbours
from tracer.io import atomic
from tracer.viewpoint import measures, plots
from tracer.viewpoint.reports.context import ViewContext, apart, csv, name_direction, number
from tracer.viewpoint.survey import survey

FILES = ("views.csv", "measures.png", "best_and_worst.png")
"""The report writes files of these names."""
HEADINGS = ("measure", "good is", "best view", "value", "worst view", "value", "median")
"""The columns of the table have these headings."""
SHOWN = 3
"""The sheet shows this many of the best, and as many of the worst, views of each measure."""


def measure(context: ViewContext, names: Sequence[str], level: int) -> list[list[str]]:
    """Write ``FILES`` and return the lines of the table under ``HEADINGS``."""
    subject, stand = context.opened.subject, context.stand
    directions, triangles = icosphere(level)
    views = stand.viewpoints(directions)
    values = survey(
        subject,
        views,
        stand.lens,
        context.rays,
        names,
        background=context.background,
        beside=neighbours(triangles),
        progress=lambda done, total: context.say("views", done, total),
    )
    stderr = {}
    if context.rays.random and "entropy" in names:
        estimate = context.gauge("entropy").estimate(views)
        values["entropy"], stderr["entropy_stderr"] = estimate.entropy, estimate.stderr
    lines, marks, chosen, captions = [], [], [], []
    for name in names:
        measured = measures.get(name)
        good = np.nan_to_num((1 if measured.best == "most" else -1) * values[name], neginf=-np.inf)
        best, worst = int(good.argmax()), int(good.argmin())
        shown = [values[name][best], values[name][worst], float(np.median(values[name]))]
        places = [name_direction(directions[k], stand.up) for k in (best, worst)]
        errors = stderr.get(f"{name}_stderr")
        texts = [number(value) for value in shown]
        if errors is not None:
            texts[:2] = [f"{text} ± {number(errors[k])}" for text, k in zip(texts, (best, worst), strict=False)]
        lines.append([name, measured.best, places[0], texts[0], places[1], *texts[1:]])
        marks.append({"best": directions[best], "worst": directions[worst]})
        extremes = apart(good, directions, SHOWN) + apart(-good, directions, SHOWN)[::-1]
        chosen += extremes
        captions += [
            f"{name}\n{'best' if k < SHOWN else 'worst'} {values[name][view]:.4g}" for k, view in enumerate(extremes)
        ]
    context.say("pictures", 0, 2)
    plots.sphere_plot(
        context.folder / "measures.png",
        [f"{name} (good: {measures.get(name).best})" for name in names],
        directions,
        triangles,
        [values[name] for name in names],
        stand.up,
        marks=marks,
    )
    context.say("pictures", 1, 2)
    unique = sorted(set(chosen))
    pictures = dict(zip(unique, context.pictures(views[np.array(unique)]), strict=True))
    plots.sheet(context.folder / "best_and_worst.png", [pictures[k] for k in chosen], captions, 2 * SHOWN)
    columns = {name: values[name] for name in names} | stderr
    rows = [[*directions[k], *(column[k] for column in columns.values())] for k in range(len(directions))]
    atomic.write_text(context.folder / "views.csv", csv(("x", "y", "z", *columns), rows))
    return lines
