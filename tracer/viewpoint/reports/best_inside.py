"""Find the best view of a room from inside: its picture, a camera for Mitsuba, and a plan of all places."""

from __future__ import annotations

import json
import time

import numpy as np

from tracer.core.arrays import Floats
from tracer.core.sphere import frame
from tracer.errors import SceneError
from tracer.io import atomic, exr
from tracer.viewpoint import measures, plots
from tracer.viewpoint.camera import write_sensors
from tracer.viewpoint.inside import FIELD_OF_VIEW, Pose, best_inside, value_inside, viewpoints_of
from tracer.viewpoint.lens import Perspective
from tracer.viewpoint.reports.best import PICTURE
from tracer.viewpoint.reports.context import ViewContext, name_direction, number, require_sight
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
    value = value_inside(
        context.opened.subject,
        room,
        name,
        preferred,
        context.background,
        lambda done, total: context.say("views inside", done, total),
    )
    pose, best_value, poses, values = best_inside(room, value, context.rays)
    require_sight(bool(np.any(np.isfinite(values))))
    if not np.isfinite(best_value[0]):
        raise SceneError(f"No view inside has a finite {name}; choose another measure.")
    seconds, sign = time.perf_counter() - start, 1 if preferred == "most" else -1
    context.say("pictures", 0, 1)
    view, lens = viewpoints_of(room, pose), Perspective(FIELD_OF_VIEW)
    exr.write_png(context.folder / "best.png", context.pictures(view, PICTURE, lens)[0])
    write_sensors(context.folder / "camera.xml", view, lens)
    best_of_places = np.full(len(room.places), np.nan)
    for place in np.unique(poses.place):
        best_of_places[place] = values[poses.place == place].max()
    draw_plan(context, room, sign * best_of_places, pose, name)
    report = {
        "measure": name,
        "good": preferred,
        "inside": True,
        "eye": view.eyes[0].tolist(),
        "direction": view.forward[0].tolist(),
        "origin": list(context.opened.origin),
        "up": view.up[0].tolist(),
        "field_of_view": FIELD_OF_VIEW,
        "value": sign * float(best_value[0]),
        "places": len(room.places),
        "height": room.height,
    }
    atomic.write_text(context.folder / "best.json", json.dumps(report, indent=1) + "\n")
    place = ", ".join(f"{coordinate:.3g}" for coordinate in view.eyes[0])
    direction = name_direction(view.forward[0], room.up)
    return [[place, direction, number(sign * float(best_value[0])), str(len(room.places)), f"{seconds:.2f}"]]


def draw_plan(context: ViewContext, room: Room, values: Floats, pose: Pose | None, name: str) -> None:
    """Write the plan of a room, seen from above: the best value (P,) at each place, and the best view as an arrow."""
    plot = plots.figure(5.2, 4.4)
    axis = plot.subplots()
    right, ahead = frame(room.up)
    tried = np.isfinite(values)
    x, y = room.places @ right, room.places @ ahead
    axis.plot(x[~tried], y[~tried], ".", color="0.8", markersize=3)
    points = axis.scatter(x[tried], y[tried], c=values[tried], cmap="viridis", s=26)
    plot.colorbar(points, ax=axis, label=f"best {name} at each place")
    if pose is not None:
        view = viewpoints_of(room, pose)
        tail = np.array([view.eyes[0] @ right, view.eyes[0] @ ahead])
        tip = np.array([view.forward[0] @ right, view.forward[0] @ ahead]) * 3 * room.spacing
        axis.annotate("", tail + tip, tail, arrowprops={"color": "red", "width": 2, "headwidth": 8})
    axis.set_aspect("equal")
    axis.set_xlabel("floor plan, seen from above, in units of the scene")
    plots.save(plot, context.folder / "plan.png")
