"""The best view: the paper's search, and an exhaustive one to compare it with.

A search is given a function from directions (V, 3) to values (V,), of which larger ones are better, and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tracer.core.arrays import Floats
from tracer.core.sphere import angle, icosphere, middle, octants
from tracer.viewpoint.direction_measure import ring

Valued = Callable[[Floats], Floats]
"""Such a function maps directions (V, 3) to values (V,), of which larger ones are better."""
SMALLEST_EDGE = np.radians(0.5)
"""Triangles are not split if this would make both edges at the best corner shorter than this angle in radians."""
REFINED = 8
"""This many of the best viewpoints of a grid are refined."""
FINEST = np.radians(0.1)
"""A viewpoint is refined until the distance of the views around it is at most this angle in radians."""
MOST_ROUNDS = 40
"""Refinement ends after this many rounds: where a measure is noisy, a better view is always a little further on."""


@dataclass(frozen=True)
class Found:
    """The best view that was found."""

    direction: Floats
    """(3,)."""
    value: float
    """The value of the view, as large as the search could make it."""
    evaluations: int
    """Number of directions that were measured."""
    steps: list[tuple[Floats, float]] = field(default_factory=list, repr=False)
    """Directions that were the best so far, and their values."""


def paper_search(value: Valued, all_octants: bool = False) -> Found:
    """Return the best view by recursive subdivision of a spherical triangle (the paper, section 4.1.1).

    The ends of the three axes are measured, and the better ends of each axis span the first triangle ("the three best"
    of the six ends may include two opposite ones, which span none). From the best corner A of a triangle ABC, the
    middles E of AB and F of AC are measured, and AEF is the next triangle, as long as E or F is better than A. The
    search is greedy: it ends where A is best. ``all_octants`` starts from each of the eight triangles.
    """
    axes, triangles = octants()
    values = value(axes)
    evaluations = len(axes)
    best_ends = {k if values[k] >= values[k + 1] else k + 1 for k in (0, 2, 4)}
    starts = [corners for corners in triangles if all_octants or set(corners.tolist()) == best_ends]
    descents = []
    for corners in starts:
        descents.append(descend(value, axes[corners], values[corners]))
        evaluations += descents[-1].evaluations
    best = max(descents, key=lambda descent: descent.value)
    return Found(best.direction, best.value, evaluations, best.steps)


def descend(value: Valued, triangle: Floats, values: Floats) -> Found:
    """Return the best view that is found by splitting a triangle (3, 3) with known values (3,) at its best corner."""
    order = np.argsort(-values, kind="stable")
    triangle, values = triangle[order], values[order]
    steps = [(triangle[0], float(values[0]))]
    evaluations = 0
    while angle(triangle[0], triangle[1:]).max() > 2 * SMALLEST_EDGE:
        middles = middle(triangle[0], triangle[1:])
        middle_values = value(middles)
        evaluations += 2
        if not middle_values.max() > values[0]:
            break
        triangle, values = np.vstack([triangle[:1], middles]), np.append(values[:1], middle_values)
        order = np.argsort(-values, kind="stable")
        triangle, values = triangle[order], values[order]
        steps.append((triangle[0], float(values[0])))
    return Found(steps[-1][0], steps[-1][1], evaluations, steps)


def exhaustive_search(value: Valued, level: int = 3, also: Floats | None = None) -> Found:
    """Return the best view of the viewpoints of an icosphere, after refining the best few of them.

    ``also``: directions (N, 3) that are tried as well, such as axes of a crystal, as the wells of a measure can be
    narrower than any grid. A view is refined with six directions around it: it moves to the best of them if that is
    better, else their distance is halved.
    """
    grid = icosphere(level)[0]
    directions = grid if also is None else np.concatenate([grid, also])
    values = value(directions)
    evaluations = len(directions)
    chosen = np.argsort(-values, kind="stable")[:REFINED]
    steps = [(directions[chosen[0]], float(values[chosen[0]]))]
    centres, best = directions[chosen], values[chosen]
    reach = np.full(len(chosen), np.sqrt(4 * np.pi / len(grid)) / 2)
    for _ in range(MOST_ROUNDS):
        active = np.flatnonzero(reach > FINEST)
        if not active.size:
            break
        rings = np.stack([ring(centres[k], reach[k]) for k in active])
        ring_values = value(rings.reshape(-1, 3)).reshape(len(active), -1)
        evaluations += ring_values.size
        pick = ring_values.argmax(axis=1)
        improved = ring_values[np.arange(len(active)), pick] > best[active]
        moved = active[improved]
        centres[moved], best[moved] = rings[improved, pick[improved]], ring_values[improved, pick[improved]]
        reach[active[~improved]] /= 2
        if best.max() > steps[-1][1]:
            steps.append((centres[best.argmax()].copy(), float(best.max())))
    return Found(steps[-1][0], steps[-1][1], evaluations, steps)
