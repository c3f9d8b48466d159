"""Measure views from all around: a table, a sphere for each measure, and pictures of the best and worst views."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tracer.core.sphere import icosphere, neighbours
from tracer.io import atomic
from tracer.viewpoint import measures, plots, sheets
from tracer.viewpoint.reports.context import ViewContext, apart, csv, name_direction, number
from tracer.viewpoint.survey import survey

FILES = ("views.csv", "measures.png", "best_and_worst.png")
"""The report writes files of these names; many measures go on several pages, ``measures-2.png`` ..."""
HEADINGS = ("measure", "good is", "best view", "value", "worst view", "value", "median")
"""The columns of the table have these headings."""
SHOWN = 3
"""The sheet shows this many of the best, and as many of the worst, views of each measure."""
SPHERES = 4
"""A page shows this many measures as spheres."""


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
        extreme_views = {"best": best, "worst": worst}
        marks.append({text: plots.Mark(directions[k], float(values[name][k])) for text, k in extreme_views.items()})
        extremes = apart(good, directions, SHOWN) + apart(-good, directions, SHOWN)[::-1]
        chosen += extremes
        captions += [
            f"{name}\n{'best' if k < SHOWN else 'worst'} {number(values[name][view])}"
            for k, view in enumerate(extremes)
        ]
    context.say("pictures", 0, 2)
    pages = sheets.pages_of(context.folder / "measures.png", -(-len(names) // SPHERES))
    for number_of_page, page in enumerate(pages):
        part = slice(number_of_page * SPHERES, (number_of_page + 1) * SPHERES)
        plots.sphere_plot(
            page,
            [f"{name} (good: {measures.get(name).best})" for name in names[part]],
            directions,
            triangles,
            [values[name] for name in names[part]],
            stand.up,
            marks=marks[part],
        )
    sheets.remove_later_pages(pages[0], len(pages))
    context.say("pictures", 1, 2)
    unique = sorted(set(chosen))
    layout = sheets.lay_out(len(chosen), lines=2, columns=2 * SHOWN)
    pictures = dict(zip(unique, context.pictures(views[np.array(unique)], layout.size), strict=True))
    sheet = context.folder / "best_and_worst.png"
    sheets.write_sheet(sheet, [pictures[k] for k in chosen], captions, layout)
    columns = {name: values[name] for name in names} | stderr
    rows = [[*directions[k], *(column[k] for column in columns.values())] for k in range(len(directions))]
    atomic.write_text(context.folder / "views.csv", csv(("x", "y", "z", *columns), rows))
    return lines
