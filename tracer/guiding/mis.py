"""Multiple importance sampling: weights of samples that more than one technique may draw."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi


def power_heuristic(density: mi.Float, other: mi.Float) -> mi.Float:
    """Return the weight of a sample that another technique might have drawn (Veach 1997, eq. 9.13).

    It is a constant to derivatives, and 0 where neither technique draws the sample or a density is not finite.
    """
    square = dr.square(density)
    weight = square / (square + dr.square(other))
    return dr.detach(dr.select(dr.isfinite(weight), weight, 0.0))
