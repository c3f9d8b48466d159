"""The same for every pixel: the baseline of all other criteria."""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats
from tracer.criteria.registry import Evidence, criterion


@criterion("uniform", needs_radiance=False)
def uniform(evidence: Evidence) -> Floats:
    """Return ones (H, W)."""
    return np.ones_like(evidence.weight)
