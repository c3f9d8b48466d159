"""Colour and geometry contrast combined, in a refinement tree.

J. Rigau, M. Feixas and M. Sbert, "Entropy-based adaptive sampling", Graphics Interface 2003: the entropy of an image is
the entropy of its division into regions plus the sum of q_r H_r, with q_r the share of region r in the image's value
(grouping property). So a leaf of the tree contributes q times its contrast, and the leaf that contributes most is
refined. Here leaves are pixels. A leaf's contrast is DELTA times its colour contrast plus 1 - DELTA times its geometry
contrast. Both are 0 to 1: the mean colour of equation 8 is divided out of the former, as it is part of q. A pixel is
refined while q times contrast is above a threshold, which is lowered until the budget is spent.
"""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats
from tracer.criteria.colour import divided, mean_colour, perceived, ranked
from tracer.criteria.colour_contrast import contrast_of
from tracer.criteria.divergences import logarithms
from tracer.criteria.registry import Evidence, criterion
from tracer.image.colour import luminance

DELTA = 0.5
"""Weight of colour contrast, 0 to 1; the rest is the weight of geometry contrast. The papers leave it to the user."""


@criterion("rigau", needs_radiance=True, spends="priority", moments=logarithms)
def rigau(evidence: Evidence) -> Floats:
    """Return q times contrast times the number of pixels (H, W)."""
    brightness = luminance(mean_colour(evidence))
    colour = divided(perceived(evidence, contrast_of(evidence)), brightness)
    contrast = DELTA * colour + (1.0 - DELTA) * evidence.complexity.geometry_contrast
    average = float(np.mean(brightness, where=np.isfinite(brightness))) if np.isfinite(brightness).any() else 0.0
    return ranked(brightness * contrast / (average if average > 0 else 1.0), evidence)
