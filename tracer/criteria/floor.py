"""The floor under criteria that see geometry alone: shadows, gloss and indirect noise do not follow edges."""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats

FLOOR = 0.3
"""Without it allocating by geometry loses to uniform sampling on most scenes; with it it is harmless."""


def over_floor(measure: Floats) -> Floats:
    """Return sqrt(sqrt(m) + FLOOR) of a measure (H, W) of variance, 0 to 1, that knows nothing but geometry."""
    return np.sqrt(np.sqrt(np.clip(measure, 0.0, 1.0)) + FLOOR)
