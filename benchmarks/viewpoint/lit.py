"""Whether the scene's own light, as a part of complexity, chooses views in which more is seen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import harness
from benchmarks.harness import Announce
from tracer.core.arrays import Floats
from tracer.image.colour import decode_srgb, luminance
from tracer.viewpoint.direction_measure import Stand, stand
from tracer.viewpoint.inside import LENS, best_inside, viewpoints_of
from tracer.viewpoint.item_buffer import Rays, Viewpoints
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.opened import Opened
from tracer.viewpoint.rendered import render_views
from tracer.viewpoint.reports.context import ViewContext
from tracer.viewpoint.reports.floor_plan import value_of_views
from tracer.viewpoint.room import find_room
from tracer.viewpoint.search import exhaustive_search
from tracer.viewpoint.source import Counted, open_source

SIDE, LEVEL = 96, 2
"""Rays along each side of a view that is measured, and level of the view sphere."""
SIZE, SPP = 256, 64
"""Pixels along each side of a picture, and its samples per pixel."""
BINS = 64
"""Number of bins of the histogram of a picture's luminance."""
DARK = 0.01
"""Luminance below which a pixel counts as dark; 1 is white."""
WHITE = 0.999
"""A pixel is burnt out if one of its colours is at least this."""
ACROSS = 5
"""Scenes side by side in the picture."""
WAYS = {"geometry": False, "light": True}
"""Whether surfaces count as well as light shows them, by the name of the way."""


def lit_views(paths: dict[str, Path], folder: Path, announce: Announce) -> list[dict[str, Any]]:
    """Return what the pictures of the best views show, a row for each scene, and draw them into ``folder``."""
    rows, pictures = [], {}
    for name, path in paths.items():
        announce(f"light: {name}")
        shown = {
            way: picture_of_best(open_source(path, Counted("shape", by_light=by_light)))
            for way, by_light in WAYS.items()
        }
        pictures[name] = shown
        rows.append({"scene": name, **{way: content(picture) for way, picture in shown.items()}})
    if pictures:
        draw(pictures, folder / "light.png")
    return rows


def picture_of_best(opened: Opened) -> Floats:
    """Return the picture (SIZE, SIZE, 3) of the view with the greatest entropy, in the light of the scene."""
    views, lens, place = best_view(opened)
    clip = place.clip if lens is place.lens else None
    return render_views(opened.subject, views, lens, SIZE, SPP, clip)[0]


def best_view(opened: Opened) -> tuple[Viewpoints, Lens, Stand]:
    """Return the view with the greatest entropy, inside a room or from all around."""
    place = stand(opened.subject, up=opened.up, orthographic=opened.orthographic)
    context = ViewContext(opened, place, Rays(side=SIDE), True, Path(), lambda *_: None)
    room = find_room(opened.subject, place.up)
    if room is not None:
        pose = best_inside(room, value_of_views(context, room, "entropy", "most"), context.rays)[0]
        return viewpoints_of(room, pose), LENS, place
    best = exhaustive_search(context.gauge("entropy").better, LEVEL).direction
    return place.viewpoints(best[None]), place.lens, place


def content(picture: Floats) -> dict[str, float]:
    """Return what a picture shows.

    ``entropy``: of the histogram of its shown luminance, in bits; ``dark`` and ``burnt out``: shares of its pixels.
    """
    linear = luminance(decode_srgb(picture))
    shown = np.cbrt(linear)  # about as bright as it looks
    counts = np.histogram(shown, BINS, (0, 1))[0]
    share = counts[counts > 0] / counts.sum()
    return {
        "entropy": float(np.sum(share * np.log2(1 / share))),
        "dark": float(np.mean(linear < DARK)),
        "burnt out": float(np.mean(picture.max(axis=-1) >= WHITE)),
    }


def draw(pictures: dict[str, dict[str, NDArray]], path: Path) -> None:
    """Draw the pictures of both ways below each other, some scenes side by side."""
    bands = -(-len(pictures) // ACROSS)
    with harness.figure(path, 2.6 * min(len(pictures), ACROSS), 5.6 * bands) as figure:
        axes = figure.subplots(len(WAYS) * bands, min(len(pictures), ACROSS), squeeze=False)
        for axis in axes.flat:
            axis.axis("off")
        for number, (name, shown) in enumerate(pictures.items()):
            band, column = divmod(number, ACROSS)
            for row, way in enumerate(WAYS):
                axis = axes[len(WAYS) * band + row][column]
                axis.imshow(shown[way])
                axis.set_title(f"{name}\n{way}" if row == 0 else way, fontsize=9)
