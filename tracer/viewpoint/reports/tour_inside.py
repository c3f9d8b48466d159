"""Walk through a room with a camera: its way in the floor plan, frames, and a film."""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats
from tracer.core.sphere import frame
from tracer.io import atomic
from tracer.viewpoint import plots
from tracer.viewpoint.camera import write_sensors
from tracer.viewpoint.inside import FIELD_OF_VIEW, Pose, best_inside, value_inside, viewpoints_of
from tracer.viewpoint.item_buffer import Rays
from tracer.viewpoint.lens import Perspective
from tracer.viewpoint.reports.context import ViewContext, csv, name_direction, number, require_sight
from tracer.viewpoint.reports.tour import Film, require_film_maker, write_frames
from tracer.viewpoint.room import Room
from tracer.viewpoint.tour import Avoided
from tracer.viewpoint.walk import smooth_walk, walk


def tour_inside(
    context: ViewContext, room: Room, name: str, steps: int, film: Film, avoided: Avoided = "start"
) -> list[list[str]]:
    """Write the files of ``tour``; return the lines of the table under its headings.

    The walk has ``steps`` steps from the best view on, each to a place beside it. ``avoided``: what the camera keeps
    away from. Raises MissingPackageError without Pillow, SceneError if no view sees anything.
    """
    require_film_maker()
    preferred = context.good(name)
    value = value_inside(
        context.opened.subject,
        room,
        name,
        preferred,
        context.background,
        lambda done, total: context.say("views inside", done, total),
    )
    start, _, _, values = best_inside(room, value, context.rays)
    require_sight(bool(np.any(np.isfinite(values))))
    worst = float(values[np.isfinite(values)].min())

    def good(pose: Pose, rays: Rays) -> Floats:
        """Return how good poses are, at least 0."""
        found = value(pose, rays)
        return np.where(np.isfinite(found), np.maximum(found - (0.0 if preferred == "most" else worst), 0.0), 0.0)

    path = walk(room, good, context.rays, start, steps, avoided)
    viewpoints, lens = smooth_walk(context.opened.subject, room, path.poses, film.frames), Perspective(FIELD_OF_VIEW)
    draw_way(context, room, viewpoints.eyes, viewpoints.forward, f"{name}: {steps} steps inside")
    write_frames(context, viewpoints, film, lens)
    write_sensors(context.folder / "cameras.xml", viewpoints, lens, film.size)
    views = viewpoints_of(room, path.poses)
    table = list(zip(views.eyes, views.forward, path.values, path.weights, path.distances, strict=True))
    rows = [[k, *eye, *forward, *numbers] for k, (eye, forward, *numbers) in enumerate(table)]
    headings = ("step", "x", "y", "z", "forward_x", "forward_y", "forward_z", "value", "weight", "distance")
    atomic.write_text(context.folder / "path.csv", csv(headings, rows))
    return [
        [str(k), name_direction(forward, room.up), number(worth), number(weight), f"{distance:.3g}"]
        for k, (_, forward, worth, weight, distance) in enumerate(table)
    ]


def draw_way(context: ViewContext, room: Room, eyes: Floats, forward: Floats, title: str) -> None:
    """Write the way (N, 3) of a camera in the plan of a room; arrows show the directions (N, 3) in which it looks."""
    plot = plots.figure(5.2, 4.4)
    axis = plot.subplots()
    right, ahead = frame(room.up)
    axis.plot(room.places @ right, room.places @ ahead, ".", color="0.8", markersize=4)
    x, y = eyes @ right, eyes @ ahead
    axis.plot(x, y, color="tab:blue")
    shown = np.linspace(0, len(eyes) - 1, min(len(eyes), 14)).round().astype(int)
    axis.quiver(x[shown], y[shown], (forward @ right)[shown], (forward @ ahead)[shown], color="tab:red", width=0.006)
    axis.plot(x[:1], y[:1], "o", color="black", label="start")
    axis.legend(loc="best")
    axis.set_aspect("equal")
    axis.set_title(title)
    axis.set_xlabel("floor plan, seen from above, in units of the scene")
    plots.save(plot, context.folder / "path.png")
