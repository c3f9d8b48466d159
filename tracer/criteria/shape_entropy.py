"""Entropy of the shape IDs that pilot rays hit: viewpoint complexity in a block of pixels (the paper, section 4.4).

The importance is the square root of the entropy, which is nearest to a standard deviation, plus a floor: shadows, gloss
and indirect noise do not follow edges, and without the floor this criterion loses to uniform sampling on most scenes.
It sees no radiance, so the picture stays unbiased.
"""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats
from tracer.criteria.floor import over_floor
from tracer.criteria.registry import Evidence, criterion


@criterion("shape_entropy", needs_radiance=False)
def shape_entropy(evidence: Evidence) -> Floats:
    """Return sqrt(sqrt(H / log2 K) + FLOOR) (H, W); H is the entropy of shape IDs of K rays of a pixel or block."""
    complexity = evidence.complexity
    return over_floor(complexity.shape_entropy / np.log2(complexity.same_shape.shape[-1]))
