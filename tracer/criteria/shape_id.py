"""The rule of pbrt-v2: eight times the samples where pilot rays hit different things.

In the sampler ``adaptive`` with ``method`` "shapeid" of pbrt-v2 (``src/samplers/adaptive.cpp``), a pixel in which any
two of 4 rays differ in shape or primitive is sampled anew with ``maxsamples`` 32 in place of ``minsamples`` 4. Here
both numbers are scaled so that the budget is spent. On a dense mesh every ray hits another primitive, and all pixels
get the same.
"""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats
from tracer.criteria.registry import Evidence, criterion

REFINED = 32.0 / 4.0
"""Samples of a pixel that is refined over samples of a pixel that is not: pbrt's ``maxsamples`` over ``minsamples``."""


@criterion("shape_id", needs_radiance=False)
def shape_id(evidence: Evidence) -> Floats:
    """Return 8 where face IDs differ, and 1 elsewhere (H, W). Face IDs also differ where shapes do.

    Samples are allocated as for other criteria that see IDs alone: no pixel is left without a sample.
    """
    different = evidence.complexity.face_gini > 0.5 / evidence.complexity.same_face.shape[-1]
    return np.where(different, REFINED, 1.0)
