"""Find the best view of a room from inside: its picture, a camera for Mitsuba, and a plan of all places."""

from __future__ import annotations

import json
import time

import numpy as np

from tracer.core.arrays import Floats
from tracer.errors import SceneError
from tracer.io import atomic, exr
from tracer.viewpoint import measures, plots
from tracer.viewpoint.camera import write_sensors
from tracer.viewpoint.inside import LENS, best_inside, viewpoints_of
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.reports.best import PICTURE
from tracer.viewpoint.reports.context import ViewContext, name_direction, number, require_sight
from tracer.viewpoint.reports.floor_plan import empty_plan, flat, value_of_views
from tracer.viewpoint.room import Room

FILES = ("best.png", "plan.png", "camera.xml", "best.json")
"""The report writes files of these names."""
HEADINGS = ("place", "looks to", "value", "places", "seconds")
"""The columns of the table have these headings."""


def best_inside_report(
    context: ViewContext, room: Room, name: str, good: measures.Best | None = None
) -> list[list[str]]:
    """Write ``FILES`` for the best view of a room, and return the line of the table under ``HEADINGS``.

    ``good``: whether good views have the most or the least of the measure. Raises SceneError if no view sees anything.
    """
    start = time.perf_counter()
    preferred = context.good(name, good)
    value = value_of_views(context, room, name, preferred)
    pose, best_value, poses, values = best_inside(room, value, context.rays)
    require_sight(bool(np.any(np.isfinite(values))))
    if not np.isfinite(best_value[0]):
        raise SceneError(f"No view inside has a finite {name}; choose another measure.")
    seconds, sign = time.perf_counter() - start, 1 if preferred == "most" else -1
    context.say("pictures", 0, 1)
    view = viewpoints_of(room, pose)
    exr.write_png(context.folder / "best.png", context.pictures(view, PICTURE, LENS)[0])
    write_sensors(context.folder / "camera.xml", view, LENS)
    best_of_places = np.full(len(room.places), np.nan)
    for place in np.unique(poses.place):
        best_of_places[place] = values[poses.place == place].max()
    draw_plan(context, room, sign * best_of_places, view, name)
    report = {
        "measure": name,
        "good": preferred,
        "inside": True,
        "eye": view.eyes[0].tolist(),
        "direction": view.forward[0].tolist(),
        "origin": list(context.opened.origin),
        "up": view.up[0].tolist(),
        "field_of_view": LENS.field_of_view,
        "value": sign * float(best_value[0]),
        "places": len(room.places),
        "height": room.height,
    }
    atomic.write_text(context.folder / "best.json", json.dumps(report, indent=1) + "\n")
    place = ", ".join(f"{coordinate:.3g}" for coordinate in view.eyes[0])
    direction = name_direction(view.forward[0], room.up)
    return [[place, direction, number(sign * float(best_value[0])), str(len(room.places)), f"{seconds:.2f}"]]


def draw_plan(context: ViewContext, room: Room, values: Floats, view: Viewpoints, name: str) -> None:
    """Write the plan of a room: the best value (P,) at each place that was tried, and the best view as an arrow."""
    plot, axis = empty_plan(room)
    tried = np.isfinite(values)
    points = axis.scatter(*flat(room, room.places[tried]), c=values[tried], cmap="viridis", s=26)
    plot.colorbar(points, ax=axis, label=f"best {name} at each place")
    tail = flat(room, view.eyes[0])
    tip = flat(room, view.eyes[0] + 3 * room.spacing * view.forward[0])
    axis.annotate("", tip, tail, arrowprops={"color": "red", "width": 2, "headwidth": 8})
    plots.save(plot, context.folder / "plan.png")
