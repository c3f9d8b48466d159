"""Every pixel the same: what all others are measured against."""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats
from tracer.criteria.registry import Evidence, criterion


@criterion("uniform", needs_radiance=False)
def uniform(evidence: Evidence) -> Floats:
    """Return ones."""
    return np.ones_like(evidence.weight)
