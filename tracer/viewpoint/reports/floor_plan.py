"""What the reports of a room have in common: the measure of its views, and the plan of its floor."""

from __future__ import annotations

from typing import Any

from tracer.core.arrays import Floats
from tracer.core.sphere import frame
from tracer.viewpoint import measures, plots
from tracer.viewpoint.inside import Valued, value_inside
from tracer.viewpoint.reports.context import ViewContext
from tracer.viewpoint.room import Room


def value_of_views(context: ViewContext, room: Room, name: str, good: measures.Best) -> Valued:
    """Return the value of poses in the room by a measure, which tells the person how far it is."""
    return value_inside(
        context.opened.subject,
        room,
        name,
        good,
        context.background,
        lambda done, total: context.say("views inside", done, total),
    )


def flat(room: Room, vectors: Floats) -> tuple[Floats, Floats]:
    """Return x and y, (...) each, of places or directions (..., 3) in the plan of a room, seen from above."""
    right, ahead = frame(room.up)
    return vectors @ right, vectors @ ahead


def empty_plan(room: Room) -> tuple[Any, Any]:
    """Return the figure and the axes of a plan that shows where a person could stand."""
    plot = plots.figure(5.2, 4.4)
    axis = plot.subplots()
    axis.plot(*flat(room, room.places), ".", color="0.8", markersize=4, zorder=0)
    axis.set_aspect("equal")
    axis.set_xlabel("floor plan, seen from above, in units of the scene")
    return plot, axis
