"""Choose a set of views that shows everything: its pictures and cameras, and what no view sees."""

from __future__ import annotations

import numpy as np

from tracer.core.sphere import icosphere
from tracer.io import atomic
from tracer.viewpoint import plots, sheets
from tracer.viewpoint.camera import write_sensors
from tracer.viewpoint.cover import Cover, Rule, cover
from tracer.viewpoint.reports.context import ViewContext, csv, name_direction, require_sight

FILES = ("views.png", "sphere.png", "views.csv", "cameras.xml")
"""The report writes files of these names; many views go on several pages, ``views-2.png`` ..."""
HEADINGS = ("view", "from", "shown well")
"""The columns of the table have these headings."""


def cover_report(
    context: ViewContext, level: int, quality: float, rule: Rule, most: int | None, enough: float, gain: float = 0.0
) -> tuple[list[list[str]], Cover]:
    """Write ``FILES``; return the lines of the table under ``HEADINGS``, and the set of views."""
    directions, triangles = icosphere(level)
    views = context.stand.viewpoints(directions)
    view_set = cover(
        context.opened.subject,
        views,
        context.stand.lens,
        context.rays,
        quality,
        rule,
        most,
        enough,
        gain,
        told=lambda count, covered: context.say(f"{count} views", round(1000 * covered), 1000),
    )
    require_sight(len(view_set.unseen) < context.opened.subject.count)
    chosen = directions[view_set.chosen]
    names = [name_direction(direction, context.stand.up) for direction in chosen]
    shares = [f"{100 * share:.1f} %" for share in view_set.covered]
    if len(chosen):
        captions = [f"{k + 1}: {name}\n{share}" for k, (name, share) in enumerate(zip(names, shares, strict=True))]
        layout = sheets.lay_out(len(chosen), lines=2)
        pictures = context.pictures(views[view_set.chosen], layout.size)
        sheets.write_sheet(context.folder / "views.png", pictures, captions, layout)
    closeness = (directions @ chosen.T).max(axis=1) if len(chosen) else np.zeros(len(directions))
    marks = {str(k + 1): plots.Mark(direction, 0.0) for k, direction in enumerate(chosen)}
    nearest = np.degrees(np.arccos(np.clip(closeness, -1, 1)))
    title = "degrees to the nearest view of the set"
    plots.sphere_plot(
        context.folder / "sphere.png", [title], directions, triangles, [nearest], context.stand.up, marks=[marks]
    )
    rows = [
        [k + 1, *direction, share] for k, (direction, share) in enumerate(zip(chosen, view_set.covered, strict=True))
    ]
    atomic.write_text(context.folder / "views.csv", csv(("view", "x", "y", "z", "shown_well"), rows))
    write_sensors(context.folder / "cameras.xml", views[view_set.chosen], context.stand.lens, clip=context.stand.clip)
    lines = [[str(k + 1), name, share] for k, (name, share) in enumerate(zip(names, shares, strict=True))]
    return lines, view_set
