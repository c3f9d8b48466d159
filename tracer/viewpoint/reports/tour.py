"""Explore with a camera: its path on the sphere, frames, and a film that a browser plays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tracer.core.arrays import Floats
from tracer.core.sphere import angle, icosphere
from tracer.io import atomic, exr
from tracer.viewpoint import plots
from tracer.viewpoint.camera import write_sensors
from tracer.viewpoint.direction_measure import Gauge
from tracer.viewpoint.films import require_film_maker, there_and_back, write_film
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.reports.context import ViewContext, csv, name_direction, number, require_sight
from tracer.viewpoint.search import exhaustive_search
from tracer.viewpoint.tour import Avoided, carried, explore, smooth

FILES = ("path.png", "path.csv", "cameras.xml")
"""The report writes files of these names, frames, and a film."""
FILM = "tour.webp"
"""The film has this name, unless another is asked for."""
HEADINGS = ("step", "view", "value", "weight", "from start")
"""The columns of the table have these headings."""
LEVEL = 2
"""The best view is searched, and the measure drawn, on an icosphere of this level."""


@dataclass(frozen=True)
class Film:
    """What a film is like."""

    frames: int
    """Number of pictures."""
    size: int
    """Width and height in pixels."""
    name: str = FILM
    """Its name decides its format."""
    is_loop: bool = False
    """Whether the camera comes back to where it started; otherwise the film plays forwards and backwards."""


def tour(
    context: ViewContext, name: str, steps: int, step: float, film: Film, avoided: Avoided = "start"
) -> list[list[str]]:
    """Write ``FILES`` and ``frame0000.png`` ...; return the lines of the table under ``HEADINGS``.

    The tour has ``steps`` steps of ``step`` degrees from the best view on. ``avoided``: what the camera keeps away
    from. Raises MissingPackageError without what writes the film, SceneError if no view sees anything.
    """
    require_film_maker(film.name)
    gauge = context.gauge(name)
    directions, triangles = icosphere(LEVEL)
    context.say("best view", 0, 1)
    values = gauge(directions)
    require_sight(gauge.sighted)
    good = goodness(gauge, values)
    start = exhaustive_search(good, LEVEL, context.opened.axes).direction
    path = explore(good, start, steps, np.radians(step), avoided=avoided, is_loop=film.is_loop)
    up = context.stand.up
    shown = gauge(path.directions)
    ends = {"start": 0, "end": -1}
    plots.sphere_plot(
        context.folder / "path.png",
        [f"{name}: {steps} steps of {step:g}°"],
        directions,
        triangles,
        [values],
        up,
        smooth(path.directions, 12 * steps + 1, film.is_loop),
        [{text: plots.Mark(path.directions[k], float(shown[k])) for text, k in ends.items()}],
    )
    directions = smooth(path.directions, film.frames, film.is_loop)
    viewpoints = carried(context.stand.centre, context.stand.distance, directions, up, film.is_loop)
    write_frames(context, viewpoints, film)
    write_sensors(context.folder / "cameras.xml", viewpoints, context.stand.lens, film.size, context.stand.clip)
    distances = np.degrees(angle(path.directions, path.directions[0]))
    table = list(zip(path.directions, shown, path.weights, distances, strict=True))
    rows = [[k, *place, value, weight, distance] for k, (place, value, weight, distance) in enumerate(table)]
    atomic.write_text(context.folder / "path.csv", csv(("step", "x", "y", "z", "value", "weight", "degrees"), rows))
    return [
        [str(k), name_direction(place, up), number(value), number(weight), f"{distance:.0f}°"]
        for k, (place, value, weight, distance) in enumerate(table)
    ]


def write_frames(context: ViewContext, viewpoints: Viewpoints, film: Film, lens: Lens | None = None) -> None:
    """Write the pictures of viewpoints as frames, and as a film; ``lens``: by default that of the stand."""
    pictures = []
    for k in range(len(viewpoints)):
        context.say("frames", k, len(viewpoints))
        picture = context.pictures(viewpoints[k : k + 1], film.size, lens)[0]
        exr.write_png(context.folder / f"frame{k:04d}.png", picture)
        pictures.append(np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8))
    write_film(context.folder / film.name, pictures if film.is_loop else there_and_back(pictures))
    for frame in context.folder.glob("frame[0-9][0-9][0-9][0-9].png"):
        if int(frame.stem[5:]) >= len(viewpoints):
            frame.unlink()  # left by a longer tour


def goodness(gauge: Gauge, values: Floats) -> Any:
    """Return the measure as a function that is never negative, and larger if better, as a tour needs it.

    If less is better, it is the difference to the worst of ``values`` (V,), which must be those of the gauge's last
    call. It is 0 for a view that sees nothing.
    """
    worst = float(np.max(values[gauge.seen & np.isfinite(values)], initial=0.0))

    def good(directions: Floats) -> Floats:
        measured = gauge(directions)
        return np.where(gauge.seen, np.maximum(measured if gauge.sign > 0 else worst - measured, 0.0), 0.0)

    return good
