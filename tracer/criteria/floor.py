"""The floor under criteria that see geometry alone: shadows, gloss and indirect noise do not follow edges."""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats

FLOOR = 0.3
"""Floor under the root of a measure, 0 to 1. Without it, allocation by geometry loses to uniform sampling on most
scenes; with it, it does no harm."""


def over_floor(measure: Floats) -> Floats:
    """Return sqrt(sqrt(m) + FLOOR) of a measure m (H, W) of variance, 0 to 1, that is computed from geometry alone."""
    return np.sqrt(np.sqrt(np.clip(measure, 0.0, 1.0)) + FLOOR)
