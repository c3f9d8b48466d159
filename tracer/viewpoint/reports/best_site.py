"""The best view of a molecule from the surface of another one: its picture, a camera, and the sites atom by atom."""

from __future__ import annotations

import json

import numpy as np

from tracer.core.sphere import frame
from tracer.io import atomic, exr
from tracer.viewpoint import measures
from tracer.viewpoint.camera import write_sensors
from tracer.viewpoint.docking import Pair, find_sites
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.lens import Perspective
from tracer.viewpoint.reports.best import PICTURE
from tracer.viewpoint.reports.context import ViewContext, csv, number, require_sight

FILES = ("best.png", "sites.csv", "camera.xml", "best.json")
"""The report writes files of these names."""
HEADINGS = ("atom", "element", "place", "value")
"""The columns of the table have these headings."""
SHOWN = 10
"""The table shows this many atoms."""
FIELD_OF_VIEW = 90.0
"""Degrees that the picture shows."""


def best_site(context: ViewContext, pair: Pair, name: str, good: measures.Best | None = None) -> list[list[str]]:
    """Write ``FILES``, and return the lines of the table under ``HEADINGS``: the best points of the best atoms.

    ``good``: whether good views have the most or the least of the measure. Raises SceneError if no point of the surface
    sees the other molecule.
    """
    preferred = context.good(name, good)
    sign = 1 if preferred == "most" else -1
    context.say("views from the surface", 0, 2)
    sites = find_sites(pair.seen, pair.seen_from, context.opened.subject, name, preferred, context.background)
    require_sight(bool(np.any(np.isfinite(sites.values))))
    order = [point for point in sites.best_of_atoms() if np.isfinite(sites.values[point])]
    rows = [
        [sites.atom[k] + 1, pair.seen_from.symbols[sites.atom[k]], *sites.points[k], sign * sites.values[k]]
        for k in order
    ]
    context.say("picture", 1, 2)
    eye = sites.points[order[0]]
    forward = pair.seen.positions.mean(axis=0) - eye
    forward /= max(float(np.linalg.norm(forward)), 1e-12)
    right, up = frame(forward)
    view, lens = Viewpoints(eye[None], forward[None], right[None], up[None]), Perspective(FIELD_OF_VIEW)
    exr.write_png(context.folder / "best.png", context.pictures(view, PICTURE, lens)[0])
    write_sensors(context.folder / "camera.xml", view, lens)
    atomic.write_text(context.folder / "sites.csv", csv(("atom", "element", "x", "y", "z", "value"), rows))
    report = {
        "measure": name,
        "good": preferred,
        "atom": int(rows[0][0]),
        "element": str(rows[0][1]),
        "eye": eye.tolist(),
        "origin": list(context.opened.origin),
        "remarks": list(context.opened.remarks),
        "direction": forward.tolist(),
        "value": float(rows[0][-1]),
        "points": len(sites.points),
    }
    atomic.write_text(context.folder / "best.json", json.dumps(report, indent=1) + "\n")
    return [
        [str(atom), str(element), ", ".join(f"{value:.2f}" for value in place), number(float(worth))]
        for atom, element, *place, worth in rows[:SHOWN]
    ]
