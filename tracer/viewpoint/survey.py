"""Measure views: any number of measures, of all viewpoints, in one pass or two.

Measures that compare a view with all others need sums over all views first. For these the rays are traced twice, as the
memory for what every view sees would grow with the number of views.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.errors import SettingsError
from tracer.progress import CountCallback
from tracer.viewpoint import measures
from tracer.viewpoint.channel import Channel, adjacent, new_channel
from tracer.viewpoint.item_buffer import Batch, Rays, Viewpoints, projected_areas
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.observation import Picture, Sight, sight_of
from tracer.viewpoint.surfaces import Subject
from tracer.viewpoint.vertices import seen_vertices


def survey(
    subject: Subject,
    viewpoints: Viewpoints,
    lens: Lens,
    rays: Rays,
    names: Sequence[str],
    *,
    background: bool = True,
    beside: Sequence[Integers] | None = None,
    channel: Channel | None = None,
    progress: CountCallback | None = None,
) -> dict[str, Floats]:
    """Return the values (V,) of each measure by its name, one for each viewpoint.

    ``beside``: for each viewpoint, the numbers of the viewpoints beside it, for measures that compare them; each must
    be beside the other. ``channel``: the channel of other viewpoints, with which views are compared instead of with one
    another. ``progress`` counts views, also those of a first pass, and may raise to stop. ``names``: of
    ``tracer.viewpoint.measures.names()``; ``tracer.viewpoint.measures.get(name).best`` says whether good views have the
    most or the least of a measure. Raises SettingsError for a measure that does not exist, or that needs what the
    subject, lens or rays do not have.

    Example::

        import tracer

        tracer.activate()
        import mitsuba as mi

        from tracer.core.sphere import icosphere
        from tracer.viewpoint.item_buffer import Rays, around
        from tracer.viewpoint.lens import Orthographic
        from tracer.viewpoint.surfaces import open_subject
        from tracer.viewpoint.survey import survey

        subject = open_subject(mi.load_dict({"type": "scene", "cube": {"type": "cube"}}))
        directions, _ = icosphere(2)
        viewpoints = around(subject.centre, 3 * subject.radius, directions)
        values = survey(subject, viewpoints, Orthographic(reach=subject.radius), Rays(side=64), ["entropy"])
        directions[values["entropy"].argmax()]  # the best view shows three sides alike
    """
    chosen = [measures.get(name) for name in names]
    needs: set[str] = {need for measure in chosen for need in measure.needs}
    check(needs, subject, lens, rays, beside)
    # Views beside one another are held until both are measured; from top to bottom, only a belt of views is held.
    order = np.argsort(-viewpoints.eyes[:, 2], kind="stable") if "neighbours" in needs else np.arange(len(viewpoints))
    views = viewpoints[order]
    passes = 2 if "channel" in needs and channel is None else 1
    report = progress or (lambda done, total: None)
    if passes == 2:
        channel = sum_up(subject, views, lens, rays, "saliency" in needs, lambda done: report(done, 2 * len(views)))
    values = {measure.name: np.zeros(len(views)) for measure in chosen}
    batches = projected_areas(subject, views, lens, rays, pictures="picture" in needs)
    sights = see(subject, views, lens, batches, background, channel)
    if "vertices" in needs:
        sights = with_vertices(sights, subject, views, lens)
    if "neighbours" in needs and beside is not None:
        sights = with_neighbours(sights, order, beside)
    for done, (number, sight) in enumerate(sights):
        for measure in chosen:
            values[measure.name][order[number]] = measure.value(sight)
        report((passes - 1) * len(views) + done + 1, passes * len(views))
    return values


def better(values: Floats, seen: NDArray[np.bool_], good: measures.Best) -> Floats:
    """Return ``values`` (V,), negated if good views have the least of them, so that more is better.

    ``seen`` (V,): whether each view sees anything; the result is -inf for one that does not, or whose value is NaN.
    """
    return np.where(seen & ~np.isnan(values), values if good == "most" else -values, -np.inf)


def sum_up(
    subject: Subject,
    viewpoints: Viewpoints,
    lens: Lens,
    rays: Rays,
    saliency: bool,
    report: Callable[[int], Any] = lambda done: None,
) -> Channel:
    """Return the channel between viewpoints and surfaces; ``saliency``: also with sums over pairs of surfaces."""
    channel = new_channel(subject.count, adjacent(subject.mesh) if saliency else None)
    for batch in projected_areas(subject, viewpoints, lens, rays):
        channel.add(batch.areas)
        report(batch.first + len(batch.areas))
    return channel


def check(needs: set[str], subject: Subject, lens: Lens, rays: Rays, beside: Sequence[Integers] | None) -> None:
    """Raise SettingsError if measures need what the subject, lens or rays do not have, or viewpoints beside a view."""
    if "picture" in needs and (rays.random or lens.wraps):
        raise SettingsError(
            "Silhouettes and depth need the view as an image: use a dense grid of rays, and a lens other than the "
            "whole sphere."
        )
    if {"vertices", "saliency"} & needs and not len(subject.mesh.triangles):
        raise SettingsError("Curvature and saliency need a mesh, and the scene has none; use another measure.")
    if subject.is_weighted and {"vertices", "picture"} & needs:
        raise SettingsError(
            "Silhouettes, depth and curvature do not tell surfaces apart, so weights cannot count; use another measure."
        )
    if "areas" in needs and not subject.areas_known:
        raise SettingsError(
            "True areas are not known of all shapes (not of instances, curves, fields); use a measure without them."
        )
    if "neighbours" in needs and beside is None:
        raise SettingsError("Stability compares a view with those beside it: measure it on a sphere of viewpoints.")


def unmet_needs(subject: Subject) -> set[str]:
    """Return what measures may need, see ``measures.registry.Need``, that a subject or its weights do not allow."""
    unmet = set() if len(subject.mesh.triangles) else {"vertices", "saliency"}
    unmet |= {"vertices", "picture"} if subject.is_weighted else set()
    return unmet | (set() if subject.areas_known else {"areas"})


def see(
    subject: Subject,
    views: Viewpoints,
    lens: Lens,
    batches: Iterator[Batch],
    background: bool,
    channel: Channel | None,
) -> Iterator[tuple[int, Sight]]:
    """Yield (number, sight) of every view."""
    for batch in batches:
        for k, areas in enumerate(batch.areas):
            sight = replace(sight_of(subject, areas, lens.image_area, background), channel=channel)
            if batch.depth is not None:
                view = views[batch.first + k : batch.first + k + 1]
                sight = replace(sight, picture=picture_of(subject, view, batch.depth[k]))
            yield batch.first + k, sight


def with_vertices(
    sights: Iterator[tuple[int, Sight]], subject: Subject, views: Viewpoints, lens: Lens
) -> Iterator[tuple[int, Sight]]:
    """Yield (number, sight) of all views, from the first to the last, with the vertices that they see."""
    for (number, sight), vertices in zip(sights, seen_vertices(subject, views, lens), strict=True):
        yield number, replace(sight, vertices=vertices)


def picture_of(subject: Subject, view: Viewpoints, depth: NDArray[np.float32]) -> Picture:
    """Return a view as an image, in which depth is 0 to 1 within the sphere around the subject."""
    centre_depth = float(np.sum((subject.centre - view.eyes[0]) * view.forward[0]))
    nearest_depth = max(centre_depth - subject.radius, 0.0)
    hit = np.isfinite(depth)
    scaled = (depth - nearest_depth) / max(centre_depth + subject.radius - nearest_depth, 1e-30)
    return Picture(hit, np.where(hit, scaled, np.nan).astype(np.float32))


def with_neighbours(
    sights: Iterator[tuple[int, Sight]], order: Integers, beside: Sequence[Integers]
) -> Iterator[tuple[int, Sight]]:
    """Yield (number, sight) of each view with its neighbours as soon as these are seen.

    A sight is forgotten when no view waits for it any more.
    """
    position = np.empty(len(order), np.int64)
    position[order] = np.arange(len(order))
    nearby = [position[beside[number]] for number in order]
    waiting = {number: len(neighbours) for number, neighbours in enumerate(nearby)}
    held: dict[int, Sight] = {}
    seen = -1
    last_needed = [max([number, *neighbours]) for number, neighbours in enumerate(nearby)]
    ready = sorted(range(len(order)), key=lambda number: last_needed[number])
    following = iter(ready)
    upcoming = next(following, None)
    for number, sight in sights:
        held[number], seen = sight, number
        while upcoming is not None and last_needed[upcoming] <= seen:
            yield upcoming, replace(held[upcoming], neighbours=[held[neighbour] for neighbour in nearby[upcoming]])
            for used in (upcoming, *nearby[upcoming]):
                waiting[used] -= 1
                if waiting[used] < 0:
                    del held[used]
            upcoming = next(following, None)
