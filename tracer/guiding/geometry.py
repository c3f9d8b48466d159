"""What a light gives to a cell as far as distances and angles tell: the square of its solid angle, seen from there.

Walls, and how bright a light is, are for the trials to find out.
"""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats
from tracer.guiding.slots import SlotPlan

LEAST_COSINE = 0.2
"""Added to the cosine at a surface: cells also have surfaces that look another way than their mean."""


def geometric_moments(points: Floats, normals: Floats, size: float, plan: SlotPlan) -> Floats:
    """Return, up to a factor for each slot, the second moment of what slots give to cells (cells, slots).

    ``points``, ``normals`` (cells, 3): in the middle of each cell; ``size``: of the cells. A slot without a place, such
    as the sky, is the same from everywhere.
    """
    has_place = np.isfinite(plan.radius)
    towards = np.where(has_place[:, None], plan.centre, 0)[None] - points[:, None]
    square = (towards**2).sum(axis=-1)
    cosine = np.maximum((towards * normals[:, None]).sum(axis=-1) / np.sqrt(np.maximum(square, 1e-300)), 0)
    near = np.where(has_place, plan.radius, 0) ** 2 + (0.5 * size) ** 2
    return np.where(has_place, np.square((LEAST_COSINE + cosine) / (square + near)), 1.0)
