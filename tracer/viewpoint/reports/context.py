"""What all reports start from, and how they name directions and values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tracer.core.arrays import Floats
from tracer.core.sphere import frame, normalised
from tracer.errors import SceneError
from tracer.progress import StepCallback
from tracer.viewpoint.direction_measure import Gauge, Stand
from tracer.viewpoint.docking import Pair
from tracer.viewpoint.headlight import look
from tracer.viewpoint.item_buffer import Rays, Viewpoints
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.measures import Best, get
from tracer.viewpoint.opened import Opened
from tracer.viewpoint.rendered import render_views
from tracer.viewpoint.room import Room

THUMBNAIL = 220
"""Pictures are by default this many pixels wide."""


@dataclass(frozen=True)
class ViewContext:
    """A subject, where to stand, how to look, and where the results go."""

    opened: Opened
    stand: Stand
    rays: Rays
    background: bool
    folder: Path
    told: StepCallback
    spp: int = 0
    """Samples per pixel with which pictures are rendered; 0: they are lit from the eye instead."""
    room: Room | None = None
    """The room that is looked at from inside; None: views are from all around."""
    pair: Pair | None = None
    """Two molecules, of which the first is seen from the surface of the second."""

    def gauge(self, name: str, good: Best | None = None) -> Gauge:
        """Return a measure as a function of direction.

        ``good``: whether good views have the most or the least of it; by default as the measure says. Good views of a
        crystal have the least entropy, as they show how atoms lie in rows (the paper, section 4.5).
        """
        return Gauge(self.opened.subject, self.stand, self.rays, name, self.background, self.good(name, good))

    def good(self, name: str, asked: Best | None = None) -> Best:
        """Return whether good views have the most or the least of a measure; see ``gauge``."""
        if asked is None and name == "entropy" and self.opened.crystal:
            return "least"
        return asked or get(name).best

    def say(self, text: str, done: int, total: int) -> None:
        """Report progress. Raises KeyboardInterrupt if the person wants to stop."""
        if self.told(text, done, total) is False:
            raise KeyboardInterrupt

    def pictures(self, viewpoints: Viewpoints, size: int = THUMBNAIL, lens: Lens | None = None) -> list[Floats]:
        """Return a picture (rows, size, 3) of each view in [0, 1], encoded as sRGB.

        ``lens``: by default that of the stand.
        """
        if self.spp:
            clip = self.stand.clip if lens is None else None
            return render_views(self.opened.subject, viewpoints, lens or self.stand.lens, size, self.spp, clip)
        return look(self.opened.subject, viewpoints, lens or self.stand.lens, size, self.opened.colours)


def require_sight(seen: bool) -> None:
    """Raise SceneError unless ``seen``: whether any view saw anything."""
    if not seen:
        raise SceneError("No view sees anything: the faces have no area, or all is out of sight; check --centre.")


def name_direction(direction: Floats, up: Floats) -> str:
    """Return the name of a direction: its degrees around ``up``, and its degrees above the horizon."""
    elevation = np.degrees(np.arcsin(np.clip(np.dot(direction, normalised(up)), -1, 1)))
    sideways, ahead = frame(-normalised(up))
    azimuth = float(np.degrees(np.arctan2(direction @ sideways, direction @ ahead)))
    return f"{round(azimuth) % 360}°, {elevation:+z.0f}°"


def number(value: float) -> str:
    """Return the text of a value in a table; a dash if it is not finite."""
    return f"{value:z.4g}" if np.isfinite(value) else "–"


def apart(values: Floats, directions: Floats, count: int, angle: float = 40.0) -> list[int]:
    """Return the numbers of the ``count`` largest ``values`` (V,) with directions at least ``angle`` degrees apart."""
    chosen: list[int] = []
    for k in np.argsort(-values, kind="stable"):
        if all(directions[k] @ directions[earlier] < np.cos(np.radians(angle)) for earlier in chosen):
            chosen.append(int(k))
        if len(chosen) == count:
            break
    return chosen


def csv(headings: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Return a table as comma-separated values; no entry holds a comma."""
    return "\n".join(",".join(str(entry) for entry in row) for row in [headings, *rows]) + "\n"
