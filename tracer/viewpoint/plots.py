"""Plots: the sphere of viewpoints coloured by a measure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.sphere import frame, normalised
from tracer.io import atomic

SAME = 0.05
"""Marks are one if the distance of their directions, about the angle in radians, is less than this."""


def figure(width: float, height: float, layout: str | None = "constrained") -> Any:
    """Return an empty figure, ``width`` x ``height`` inches, that no window shows."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout=layout)  # type: ignore[arg-type]


def save(plot: Any, path: Path, dpi: int = 110) -> None:
    """Write a figure as PNG, whole or not at all."""
    with atomic.whole(path) as temporary:
        plot.savefig(temporary, dpi=dpi, format="png")


def flat(directions: Floats, up: Floats, below: bool) -> tuple[Floats, Floats, Floats]:
    """Return (x, y, depth), each (N,), of directions (N, 3) on a map of one half of the sphere, seen from outside.

    Lambert's equal-area map: the horizon is the rim of the disc, at radius 1. ``depth`` is positive on the half that is
    shown. ``below`` shows the lower half, with y mirrored.
    """
    sign = -1.0 if below else 1.0
    right, ahead = frame(-up)
    x, y = directions @ right, directions @ ahead
    depth = sign * (directions @ normalised(up))
    scale = 1 / np.sqrt(np.maximum(1 + depth, 1e-6))
    return x * scale, sign * y * scale, depth


@dataclass(frozen=True)
class Mark:
    """A direction that is marked on a sphere."""

    direction: Floats
    """(3,)."""
    value: float
    """The value of the measure there, whose colour the mark has: it may be beyond those of the grid of viewpoints."""


def draw_sphere(
    axes: Sequence[Any],
    directions: Floats,
    triangles: Integers,
    values: Floats,
    up: Floats,
    way: Floats | None = None,
    marks: Mapping[str, Mark] | None = None,
) -> Any:
    """Draw the sphere as two discs, seen from above (``up``) and below; return the coloured patches, for a colour bar.

    ``way`` (N, 3) is drawn as a line, ``marks`` as dots with their names. The scale includes their values.
    """
    finite = np.isfinite(values)
    shown = np.where(finite, values, np.nanmax(values[finite]) if finite.any() else 0.0)
    marks = with_joined_names(marks or {})
    in_scale = [*shown, *(mark.value for mark in marks.values() if np.isfinite(mark.value))]
    patches = None
    for axis, below in zip(axes, (False, True), strict=True):
        x, y, depth = flat(directions, up, below)
        near = np.all(depth[triangles] > -0.35, axis=1)
        rim = axis.add_patch(circle())
        patches = axis.tripcolor(
            x, y, triangles[near], shown, shading="gouraud", vmin=min(in_scale), vmax=max(in_scale), cmap="viridis"
        )
        patches.set_clip_path(rim)
        if way is not None:
            x, y, depth = flat(way, up, below)
            hidden = depth < 0
            axis.plot(np.where(hidden, np.nan, x), np.where(hidden, np.nan, y), color="white", linewidth=1.6)
        finish(axis, "from below" if below else "from above")
        for name, mark in marks.items():
            x, y, depth = flat(mark.direction[None], up, below)
            if depth[0] >= 0:
                draw_mark(axis, name, float(x[0]), float(y[0]), patches.to_rgba(mark.value))
    return patches


def with_joined_names(marks: Mapping[str, Mark]) -> dict[str, Mark]:
    """Return marks of which those in the same direction, within ``SAME``, are one that has the names of all."""
    names: list[str] = []
    kept: list[Mark] = []
    for name, mark in marks.items():
        same = next(
            (k for k, other in enumerate(kept) if np.linalg.norm(other.direction - mark.direction) < SAME), None
        )
        if same is None:
            names.append(name)
            kept.append(mark)
        else:
            names[same] += f", {name}"
    return dict(zip(names, kept, strict=True))


def draw_mark(axis: Any, name: str, x: float, y: float, colour: Any) -> None:
    """Draw a dot of a colour in a disc of radius 1, with its name beside it, towards the middle of the disc."""
    from matplotlib.patheffects import withStroke

    axis.plot(x, y, "o", color=colour, markeredgecolor="red", markersize=7, markeredgewidth=1.6, clip_on=False)
    across, side = (-7, "right") if x > 0 else (7, "left")
    along = 0
    if abs(y) > 0.8:  # beside the dot there is no room in the disc
        across, side, along = 0, "center", -9 if y > 0 else 9
    text = axis.annotate(name, (x, y), fontsize=8, xytext=(across, along), textcoords="offset points", va="center")
    text.set(color="white", ha=side, path_effects=[withStroke(linewidth=2, foreground="black")])


def finish(axis: Any, title: str) -> None:
    """Give a disc its title, and show all of it without axes."""
    axis.set_title(title, fontsize=8)
    axis.set_xlim(-1.03, 1.03)
    axis.set_ylim(-1.03, 1.03)
    axis.set_aspect("equal")
    axis.axis("off")


def draw_parts(
    axes: Sequence[Any], points: Floats, triangles: Integers, values: Floats, up: Floats, most: float
) -> Any:
    """Draw spherical triangles (T, 3) of directions as ``draw_sphere`` does, each in the colour of its value.

    The scale goes from 0 to ``most``. A triangle that crosses the horizon is drawn on both discs. Return the coloured
    patches.
    """
    from matplotlib.collections import PolyCollection

    shares = np.linspace(0, 1, 9)[:-1, None]
    corners = points[triangles]
    sides = [corners[:, k, None] * (1 - shares) + corners[:, (k + 1) % 3, None] * shares for k in range(3)]
    outlines = normalised(np.concatenate(sides, axis=1))
    patches = None
    for axis, below in zip(axes, (False, True), strict=True):
        x, y, depth = flat(outlines, up, below)
        near = depth.max(axis=1) > 1e-6
        patches = PolyCollection(np.stack([x, y], axis=-1)[near], array=values[near], cmap="viridis")
        patches.set_clim(0, most)
        rim = axis.add_patch(circle())
        axis.add_collection(patches)
        patches.set_clip_path(rim)
        finish(axis, "looking down" if below else "looking up")
    return patches


def circle() -> Any:
    """Return the rim of a disc of radius 1."""
    from matplotlib.patches import Circle

    return Circle((0, 0), 1.0, facecolor="none", edgecolor="black", linewidth=0.8)


def sphere_plot(
    path: Path,
    titles: Sequence[str],
    directions: Floats,
    triangles: Integers,
    columns: Sequence[Floats],
    up: Floats,
    way: Floats | None = None,
    marks: Sequence[Mapping[str, Mark]] | None = None,
) -> None:
    """Write a plot with a sphere for each of ``columns`` (V,), coloured by its values; up to two stand in a row."""
    across = 2 if len(columns) > 1 else 1
    down = -(-len(columns) // across)
    plot = figure(6.4 * across, 3.1 * down)
    grid = plot.subfigures(down, across, squeeze=False)
    for k, values in enumerate(columns):
        panel = grid[k // across][k % across]
        axes = panel.subplots(1, 2)
        patches = draw_sphere(axes, directions, triangles, values, up, way, marks[k] if marks else None)
        panel.suptitle(titles[k], fontsize=10)
        panel.colorbar(patches, ax=list(axes), shrink=0.8)
    save(plot, path)
