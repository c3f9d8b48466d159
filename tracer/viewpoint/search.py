"""The best view: the paper's search, and an exhaustive one to compare it with.

A search is given a function from directions (V, 3) to values (V,), more being better, and knows nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tracer.core.arrays import Floats
from tracer.core.sphere import angle, icosphere, middle, octants
from tracer.viewpoint.direction_measure import ring

Valued = Callable[[Floats], Floats]
SMALLEST_EDGE = np.radians(0.5)
"""Triangles with shorter edges are not split."""
REFINED = 8
"""How many of the best viewpoints of a grid are refined."""
FINEST = np.radians(0.1)
MOST_ROUNDS = 40
"""Of refinement: where a measure is noisy there is always something better a little further on."""


@dataclass(frozen=True)
class Found:
    """The best view that was found."""

    direction: Floats
    """(3,)."""
    value: float
    """What the search made large."""
    evaluations: int
    steps: list[tuple[Floats, float]] = field(default_factory=list, repr=False)
    """Directions that were the best so far, and their values."""


def paper_search(value: Valued, all_octants: bool = False) -> Found:
    """Return the best view by recursive subdivision of a spherical triangle (the paper, section 4.1.1).

    The ends of the three axes are measured; the better end of each spans the first triangle ("the three best" of the
    six may lie opposite one another and span none). From its best corner A, the middles E of AB and F of AC are
    measured, and AEF is next, as long as E or F is better than all before. It is greedy: if A is best, it ends there.
    ``all_octants`` starts from each of the eight triangles.
    """
    axes, triangles = octants()
    values = value(axes)
    evaluations = len(axes)
    best_ends = {k if values[k] >= values[k + 1] else k + 1 for k in (0, 2, 4)}
    starts = [corners for corners in triangles if all_octants or set(corners.tolist()) == best_ends]
    found = []
    for corners in starts:
        found.append(descend(value, axes[corners], values[corners]))
        evaluations += found[-1].evaluations
    best = max(found, key=lambda one: one.value)
    return Found(best.direction, best.value, evaluations, best.steps)


def descend(value: Valued, triangle: Floats, values: Floats) -> Found:
    """Follow the best corner of a triangle (3, 3) of known values (3,)."""
    order = np.argsort(-values, kind="stable")
    triangle, values = triangle[order], values[order]
    steps = [(triangle[0], float(values[0]))]
    evaluations = 0
    while angle(triangle[0], triangle[1:]).max() > 2 * SMALLEST_EDGE:
        between = middle(triangle[0], triangle[1:])
        found = value(between)
        evaluations += 2
        if not found.max() > values[0]:
            break
        triangle, values = np.vstack([triangle[:1], between]), np.append(values[:1], found)
        order = np.argsort(-values, kind="stable")
        triangle, values = triangle[order], values[order]
        steps.append((triangle[0], float(values[0])))
    return Found(steps[-1][0], steps[-1][1], evaluations, steps)


def exhaustive_search(value: Valued, level: int = 3, also: Floats | None = None) -> Found:
    """Return the best of the viewpoints of an icosphere, refined around the best few.

    ``also``: directions (N, 3) that are tried with those, such as axes of a crystal: wells can be narrower than any
    grid. Refined by six directions around each, at half the distance whenever none of them is better.
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
        found = value(rings.reshape(-1, 3)).reshape(len(active), -1)
        evaluations += found.size
        pick = found.argmax(axis=1)
        improved = found[np.arange(len(active)), pick] > best[active]
        moved = active[improved]
        centres[moved], best[moved] = rings[improved, pick[improved]], found[improved, pick[improved]]
        reach[active[~improved]] /= 2
        if best.max() > steps[-1][1]:
            steps.append((centres[best.argmax()].copy(), float(best.max())))
    return Found(steps[-1][0], steps[-1][1], evaluations, steps)
