"""Walk through a room with a camera: its way in the floor plan, frames, and a film."""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats, evenly_chosen
from tracer.io import atomic
from tracer.viewpoint import plots
from tracer.viewpoint.camera import write_sensors
from tracer.viewpoint.films import require_film_maker
from tracer.viewpoint.inside import LENS, Pose, best_inside, viewpoints_of
from tracer.viewpoint.item_buffer import Rays
from tracer.viewpoint.novelty import Memory
from tracer.viewpoint.reports.context import ViewContext, csv, name_direction, number, require_sight
from tracer.viewpoint.reports.floor_plan import empty_plan, flat, value_of_views
from tracer.viewpoint.reports.tour import Film, write_frames
from tracer.viewpoint.room import Room
from tracer.viewpoint.tour import Avoided
from tracer.viewpoint.walk import smooth_walk, walk

ARROWS = 14
"""The plan shows the direction of the camera at this many places of its way."""


def tour_inside(
    context: ViewContext, room: Room, name: str, steps: int, film: Film, avoided: Avoided = "start"
) -> list[list[str]]:
    """Write the files of ``tour``; return the lines of the table under its headings.

    The walk has ``steps`` steps from the best view on, each to a place beside it. ``avoided``: what the camera keeps
    away from. Raises MissingPackageError without what writes the film, SceneError if no view sees anything.
    """
    require_film_maker(film.name)
    preferred = context.good(name)
    value = value_of_views(context, room, name, preferred)
    start, _, _, values = best_inside(room, value, context.rays)
    require_sight(bool(np.any(np.isfinite(values))))
    worst = float(values[np.isfinite(values)].min())

    def good(pose: Pose, rays: Rays) -> Floats:
        """Return how good poses are, at least 0."""
        found = value(pose, rays)
        return np.where(np.isfinite(found), np.maximum(found - (0.0 if preferred == "most" else worst), 0.0), 0.0)

    subject = context.opened.subject
    path = walk(room, good, context.rays, start, steps, avoided, Memory(subject, room), film.is_loop)
    viewpoints = smooth_walk(subject, room, path.poses, film.frames, film.is_loop)
    draw_way(context, room, viewpoints.eyes, viewpoints.forward, f"{name}: {steps} steps inside")
    write_frames(context, viewpoints, film, LENS)
    write_sensors(context.folder / "cameras.xml", viewpoints, LENS, film.size)
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
    plot, axis = empty_plan(room)
    axis.plot(*flat(room, eyes), color="tab:blue")
    shown = evenly_chosen(len(eyes), ARROWS)
    axis.quiver(*flat(room, eyes[shown]), *flat(room, forward[shown]), color="tab:red", width=0.006)
    axis.plot(*flat(room, eyes[:1]), "o", color="black", label="start")
    axis.legend(loc="best")
    axis.set_title(title)
    plots.save(plot, context.folder / "path.png")
