"""Complexity of the regions of a view: blocks of the image, and spherical triangles all around the eye."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.sphere import normalised, octants, solid_angle, split
from tracer.errors import SceneError, SettingsError
from tracer.io import atomic
from tracer.viewpoint import measures, plots
from tracer.viewpoint.direction_measure import stand
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.lens import Lens, Orthographic
from tracer.viewpoint.own_camera import own_camera
from tracer.viewpoint.regions import Regions, look_through_blocks, look_through_triangles
from tracer.viewpoint.reports.context import ViewContext, csv, number
from tracer.viewpoint.survey import survey, unmet_needs

FILES = ("map.png", "blocks.csv", "triangles.csv")
"""The report writes files of these names."""
HEADINGS = ("of the view", "value")
"""The columns of the table have these headings."""
KINDS = ("entropy", "gini", "distinct", "viewpoint_complexity")
"""These properties of ``Regions`` can be shown on the map."""
RAYS = 16
"""A block has this many rays along each side, and a triangle as many as a block."""
WIDTH = 960
"""The picture beside the map is this many pixels wide."""


def view_from(context: ViewContext, sensor: int, eye: tuple[float, float, float] | None) -> tuple[Viewpoints, Lens]:
    """Return (view, lens) of the camera ``sensor`` of the scene, or of an ``eye`` that looks at the context's centre.

    Raises SceneError if the scene has no such camera, SettingsError for an eye at the centre.
    """
    subject, centre = context.opened.subject, context.stand.centre
    if eye is None:
        if not subject.scene.sensors():
            raise SceneError("There is no camera to look through; say from where to look with --from X Y Z.")
        view, lens, _ = own_camera(subject.scene, sensor)
        return view, lens
    outward = np.array(eye) - centre
    distance = float(np.linalg.norm(outward))
    if distance == 0:
        raise SettingsError("The eye is where it looks at; give another --from, or another --centre.")
    orthographic = isinstance(context.stand.lens, Orthographic)
    eye_stand = stand(subject, distance, centre, context.stand.up, orthographic)
    return eye_stand.viewpoints(outward[None] / distance), eye_stand.lens


def complexity_map(context: ViewContext, view: Viewpoints, kind: str, blocks: int, level: int) -> list[list[str]]:
    """Write ``FILES`` and return the lines of the table under ``HEADINGS``: measures of the view as a whole.

    ``view`` holds a single viewpoint, whose lens is that of ``context``. ``kind``: which of ``KINDS`` is drawn. There
    are ``blocks`` blocks across the image, and as many down as make them square. ``level``: how many times the 8
    spherical triangles around the eye are split.
    """
    subject, lens = context.opened.subject, context.stand.lens
    down = max(1, round(blocks / lens.aspect))
    context.say("blocks", 0, 4)
    image = look_through_blocks(subject, view, lens, blocks, down, RAYS)
    context.say("triangles", 1, 4)
    points, triangles = spherical_triangles(level)
    eyes = np.repeat(view.eyes, len(triangles), axis=0)
    around = look_through_triangles(subject, eyes, points[triangles], RAYS**2)
    context.say("pictures", 2, 4)
    picture = context.pictures(view, WIDTH)[0]
    draw(context.folder / "map.png", picture, image, around, points, triangles, kind, context.stand.up)
    rows, columns = np.indices((down, blocks)).reshape(2, -1)
    values = [[*(getattr(image, name).ravel() for name in KINDS)], [*(getattr(around, name) for name in KINDS)]]
    table = zip(rows, columns, *values[0], strict=True)
    atomic.write_text(context.folder / "blocks.csv", csv(("row", "column", *KINDS), list(table)))
    middles, areas = normalised(points[triangles].sum(axis=1)), solid_angle(*points[triangles].transpose(1, 0, 2))
    table = zip(*middles.T, areas, *values[1], strict=True)
    atomic.write_text(context.folder / "triangles.csv", csv(("x", "y", "z", "steradians", *KINDS), list(table)))
    context.say("measures", 3, 4)
    return measured(context, view, lens)


def spherical_triangles(level: int) -> tuple[Floats, NDArray[np.int64]]:
    """Return the paper's 8 triangles (section 4.1.1), split ``level`` times: directions (N, 3), triangles (T, 3)."""
    points, triangles = octants()
    for _ in range(level):
        points, triangles = split(points, triangles)
    return points, triangles


def measured(context: ViewContext, view: Viewpoints, lens: Lens) -> list[list[str]]:
    """Return [name, value] of all measures that need no other view, and that the subject has."""
    subject = context.opened.subject
    unmet = {"channel", "neighbours", "saliency"} | unmet_needs(subject)
    names = [name for name in measures.names() if not unmet & set(measures.get(name).needs)]
    values = survey(subject, view, lens, context.rays, names, background=context.background)
    return [[name, number(values[name][0])] for name in names]


def draw(
    path: Path,
    picture: Floats,
    image: Regions,
    around: Regions,
    points: Floats,
    triangles: NDArray[np.int64],
    kind: str,
    up: Floats,
) -> None:
    """Draw the picture, its blocks, and the triangles all around the eye; both share a scale of colours."""
    blocks, parts = getattr(image, kind), getattr(around, kind)
    most = max(float(blocks.max()), float(parts.max()), 1e-9)
    aspect = picture.shape[1] / picture.shape[0]
    plot = plots.figure(11.0, 5.5 / aspect + 5.2)
    above, below = plot.subfigures(2, 1, height_ratios=(5.5 / aspect + 0.3, 4.9))
    left, right = above.subplots(1, 2)
    left.imshow(picture, aspect="equal")
    left.set_title("the view", fontsize=9)
    height, width = picture.shape[:2]
    right.imshow(picture.mean(axis=2), cmap="gray", vmin=0, vmax=1)
    colours = right.imshow(
        blocks, extent=(0, width, height, 0), alpha=0.8, vmin=0, vmax=most, cmap="viridis", interpolation="nearest"
    )
    right.set_title(f"{kind} of {blocks.shape[1]} x {blocks.shape[0]} blocks", fontsize=9)
    above.colorbar(colours, ax=[left, right], shrink=0.9)
    for axis in (left, right):
        axis.axis("off")
    discs = list(below.subplots(1, 2))
    colours = plots.draw_parts(discs, points, triangles, parts, up, most)
    below.suptitle(f"{kind} of {len(triangles)} spherical triangles around the eye", fontsize=9)
    below.colorbar(colours, ax=discs, shrink=0.8)
    plots.save(plot, path)
