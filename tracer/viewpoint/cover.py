"""The fewest views that show everything well enough, for modelling from images (the paper, section 4.3, is missing).

P. Vazquez, M. Feixas, M. Sbert and W. Heidrich, "Automatic view selection using viewpoint entropy and its application
to image-based modelling", Computer Graphics Forum 22(4), 2003: take the view of the largest entropy, count what it
shows well as background from then on, and go on until nothing is left. At the end, drop the views that the others have
made superfluous.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tracer.complexity import measures
from tracer.core.arrays import Floats, Integers
from tracer.errors import SceneError
from tracer.viewpoint.item_buffer import Rays, Viewpoints, projected_areas
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.surfaces import Subject

MOST_KEPT = 1 << 27
"""At most this many areas, views times surfaces, are kept in memory; if there are more, every round looks again."""
Rule = Literal["entropy", "area", "divergence"]
"""The rules by which the next view can be chosen, see ``cover``."""
Reason = Literal["enough", "views", "gain"]
"""Why a set ends: enough is shown, it has as many views as it may have, or no other view would add enough."""


@dataclass(frozen=True)
class Cover:
    """Chosen views and what they show."""

    chosen: Integers
    """(N,): numbers of the views in the order of choice, without the superfluous ones."""
    covered: Floats
    """(N,): share of the true area, times weight, of all surfaces that any view sees, which the views up to this one
    show well."""
    dropped: Integers
    """Numbers of the views that were chosen and became superfluous."""
    missing: Integers
    """Numbers of the surfaces that some view sees, and the set does not show well; without those of weight 0."""
    ended: Reason
    unseen: Integers
    """Numbers of the surfaces that no view sees."""
    unseen_area: float
    """True area of the unseen surfaces as a share of that of all surfaces."""

    @property
    def missing_share(self) -> float:
        """What the set does not show well, as a share of the true area, times weight, that any view sees."""
        return 1 - float(self.covered[-1]) if len(self.covered) else 1.0


def cover(
    subject: Subject,
    viewpoints: Viewpoints,
    lens: Lens,
    rays: Rays,
    quality: float = 0.5,
    rule: Rule = "entropy",
    most: int | None = None,
    enough: float = 1.0,
    gain: float = 0.0,
    told: Callable[[int, float], None] = lambda views, covered: None,
) -> Cover:
    """Return the views that show every visible surface well.

    A view shows a surface well if its projected area is at least ``quality``, in (0, 1], of the largest that it has in
    any view. ``rule``: choose the view with the largest entropy of surfaces not yet shown, or with the largest true
    area newly shown, or the one with which the sum of the projected areas in all chosen views diverges least from the
    true areas (M. Sbert and others, CAe 2005). Areas count times the weights of their surfaces, and a surface of weight
    0 need not be shown. ``most``: end after this many views. ``enough``: end when this share of
    the true area is shown. ``gain``: choose only views, after the first, that newly show at least this share of the
    true area that any view sees, and end when there is none. It is not a share of what is still missing, as that stays
    the same from the first view to the last where small surfaces have each their own best view: 4 to 9 % in all of 75
    views of a scanned bunny. ``told`` is called with the number of views and the share shown after each choice, and
    with zeros while views are traced. Raises SceneError if true areas are unknown.
    """
    if not subject.areas_known:
        raise SceneError(
            "True areas are not known of all shapes (not of instances, curves, fields), as a view set needs."
        )
    look = Look(subject, viewpoints, lens, rays, lambda: told(0, 0.0))
    largest = np.zeros(subject.count, np.float32)
    for _, areas in look:
        np.maximum(largest, areas, out=largest)
    visible = largest > 0
    counts = visible & (subject.weights > 0)
    weights = np.where(counts, np.maximum(subject.areas, 1e-300) * subject.weights, 0.0)
    missing = counts.copy()
    mixed = np.zeros(subject.count)
    chosen: list[int] = []
    shown: list[NDArray[np.bool_]] = []
    ended: Reason = "enough"
    while missing.any() and weights[missing].sum() > (1 - enough) * weights.sum():
        if len(chosen) == most:
            ended = "views"
            break
        least_area = gain * float(weights.sum()) if chosen else 0.0
        best_worth, pick, pick_shows = (-np.inf, -np.inf), -1, missing
        for number, areas in look:
            shows = (areas >= quality * largest) & missing
            if not shows.any():
                continue
            new_area = float(weights[shows].sum())
            if new_area < least_area:
                continue
            if rule == "entropy":
                worth = (worth_of(areas, missing, subject.weights, lens.image_area), new_area)
            else:
                worth = (new_area, 0.0) if rule == "area" else (-divergence_of(mixed + areas, weights), new_area)
            if worth > best_worth:
                best_worth, pick, pick_shows = worth, number, shows
        if pick < 0:
            ended = "gain"
            break
        chosen.append(pick)
        mixed += look.row(pick)
        missing &= ~pick_shows
        shown.append(look.row(pick) >= quality * largest)
        told(len(chosen), 1 - float(weights[missing].sum() / weights.sum()))
    shown = [surfaces & counts for surfaces in shown]
    remaining, dropped = without_superfluous(shown, chosen)
    covered_surfaces = np.zeros(subject.count, bool)
    covered = []
    for number in remaining:
        covered_surfaces |= shown[chosen.index(number)]
        covered.append(float(weights[covered_surfaces].sum() / weights.sum()))
    sides = 2 if subject.has_sides else 1
    areas = subject.areas[::sides]
    total_area = float(areas.sum())
    unseen = np.flatnonzero(~np.any(visible.reshape(-1, sides), axis=1))
    return Cover(
        np.array(remaining, np.int64),
        np.array(covered),
        np.array(dropped, np.int64),
        np.flatnonzero(missing),
        ended,
        unseen,
        float(areas[unseen].sum()) / total_area if total_area > 0 else 0.0,
    )


def worth_of(areas: NDArray[np.float32], missing: NDArray[np.bool_], weights: Floats, image_area: float) -> float:
    """Return the entropy in bits of a view in which all surfaces but the ``missing`` ones are background.

    ``weights`` (Z,): how much each surface counts; the background counts 1.
    """
    counted = missing & (areas > 0)
    seen = areas[counted].astype(np.float64)
    seen_weights = np.append(weights[counted], 1.0)
    return float(measures.weighted_entropy(np.append(seen, max(image_area - seen.sum(), 0.0)), seen_weights))


def divergence_of(mixed: Floats, weights: Floats) -> float:
    """Return the divergence in bits of the shares of projected areas from those of ``weights``, both (Z,).

    Surfaces of weight 0 are left out of both. The result is infinite if nothing else is seen.
    """
    seen = (mixed > 0) & (weights > 0)
    if not seen.any():
        return float("inf")
    p, q = mixed[seen] / mixed[seen].sum(), weights[seen] / weights.sum()
    return float(np.sum(p * np.log2(p / q)))


def without_superfluous(shown: list[NDArray[np.bool_]], chosen: list[int]) -> tuple[list[int], list[int]]:
    """Return (kept, dropped) views; a view is dropped if the others show all that it shows, the last chosen first."""
    if not shown:
        return [], []
    counts: Integers = np.sum(np.array(shown, np.int64), axis=0)
    dropped = []
    for k in range(len(chosen) - 1, -1, -1):
        if np.all(counts[shown[k]] > 1):
            counts -= shown[k]
            dropped.append(chosen[k])
    return [number for number in chosen if number not in dropped], dropped


class Look:
    """The areas of all views, as often as they are iterated over: from memory, or traced again if they do not fit."""

    def __init__(
        self, subject: Subject, viewpoints: Viewpoints, lens: Lens, rays: Rays, told: Callable[[], None] = lambda: None
    ) -> None:
        self.told = told
        self.arguments = (subject, viewpoints, lens, rays)
        self.kept: list[NDArray[np.float32]] | None = None
        self.fits = subject.count * len(viewpoints) <= MOST_KEPT

    def __iter__(self):  # type: ignore[no-untyped-def]  # noqa: ANN204
        """Yield (number, areas (Z,)) of every view."""
        if self.kept is not None:
            yield from enumerate(self.kept)
            return
        areas_of_views = []
        for batch in projected_areas(*self.arguments):
            self.told()
            for k, areas in enumerate(batch.areas):
                areas_of_views += [areas.copy()] if self.fits else []
                yield batch.first + k, areas
        self.kept = areas_of_views if self.fits else None

    def row(self, number: int) -> NDArray[np.float32]:
        """Return the areas (Z,) of one view."""
        if self.kept is not None:
            return self.kept[number]
        return next(areas for k, areas in self if k == number)
