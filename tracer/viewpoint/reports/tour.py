"""Explore with a camera: the path on the sphere, frames, and a film that a browser plays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.extras import require_package
from tracer.core.sphere import angle, icosphere
from tracer.io import atomic, exr
from tracer.viewpoint import plots
from tracer.viewpoint.camera import write_sensors
from tracer.viewpoint.direction_measure import Gauge
from tracer.viewpoint.reports.context import ViewContext, csv, name_direction, number, require_sight
from tracer.viewpoint.search import exhaustive_search
from tracer.viewpoint.tour import carried, explore, smooth

FILES = ("tour.webp", "path.png", "path.csv", "cameras.xml")
HEADINGS = ("step", "view", "value", "weight", "from start")
LEVEL = 2
FRAMES_PER_SECOND = 25


def tour(context: ViewContext, name: str, steps: int, step: float, frames: int, size: int) -> list[list[str]]:
    """Write ``FILES`` and ``frame0000.png`` ...; return the lines of the table under ``HEADINGS``.

    ``steps`` of ``step`` degrees from the best view; ``frames`` pictures of ``size`` pixels in all.
    """
    require_film_maker()
    gauge = context.gauge(name)
    directions, triangles = icosphere(LEVEL)
    context.say("best view", 0, 1)
    values = gauge(directions)
    require_sight(gauge.sighted)
    good = goodness(gauge, values)
    start = exhaustive_search(good, LEVEL, context.opened.axes).direction
    found = explore(good, start, steps, np.radians(step))
    up = context.stand.up
    plots.sphere_plot(
        context.folder / "path.png",
        [f"{name}: {steps} steps of {step:g}°"],
        directions,
        triangles,
        [values],
        up,
        smooth(found.directions, 12 * steps + 1),
        [{"start": found.directions[0], "end": found.directions[-1]}],
    )
    film = carried(context.stand.centre, context.stand.distance, smooth(found.directions, frames), up)
    pictures = []
    for k in range(frames):
        context.say("frames", k, frames)
        picture = context.pictures(film[k : k + 1], size)[0]
        exr.write_png(context.folder / f"frame{k:04d}.png", picture)
        pictures.append(np.rint(np.clip(picture, 0, 1) * 255).astype(np.uint8))
    write_film(context.folder / "tour.webp", pictures)
    for old in context.folder.glob("frame[0-9][0-9][0-9][0-9].png"):
        if int(old.stem[5:]) >= frames:
            old.unlink()  # of a longer tour that was here before
    write_sensors(context.folder / "cameras.xml", film, context.stand.lens, size, context.stand.clip)
    shown = gauge(found.directions)
    far = np.degrees(angle(found.directions, found.directions[0]))
    table = list(zip(found.directions, shown, found.weights, far, strict=True))
    rows = [[k, *place, value, weight, distance] for k, (place, value, weight, distance) in enumerate(table)]
    atomic.write_text(context.folder / "path.csv", csv(("step", "x", "y", "z", "value", "weight", "degrees"), rows))
    return [
        [str(k), name_direction(place, up), number(value), number(weight), f"{distance:.0f}°"]
        for k, (place, value, weight, distance) in enumerate(table)
    ]


def goodness(gauge: Gauge, values: Floats) -> Any:
    """Return the measure as a function that is never negative, more being better, as weights of places need it.

    Where less is better it is what is missing to the worst of ``values``, those of the gauge's last call. A view that
    sees nothing is worth nothing, whatever its value.
    """
    worst = float(np.max(values[gauge.seen & np.isfinite(values)], initial=0.0))

    def good(directions: Floats) -> Floats:
        found = gauge(directions)
        return np.where(gauge.seen, np.maximum(found if gauge.sign > 0 else worst - found, 0.0), 0.0)

    return good


def require_film_maker() -> Any:
    """Return the module ``PIL.Image``, which writes films. Raises MissingPackageError if it is not installed."""
    return require_package("PIL.Image", "Pillow", "The film of a tour", "view")


def write_film(path: Any, pictures: list[NDArray[np.uint8]]) -> None:
    """Write pictures (H, W, 3) as an animation, there and back again without end."""
    Image = require_film_maker()
    images = [Image.fromarray(picture) for picture in pictures]
    images += images[-2:0:-1]
    with atomic.whole(path) as temporary:
        images[0].save(
            temporary, save_all=True, append_images=images[1:], duration=1000 // FRAMES_PER_SECOND, loop=0, quality=80
        )
