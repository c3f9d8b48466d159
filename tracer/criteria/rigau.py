"""Colour and geometry contrast combined, in a refinement tree.

J. Rigau, M. Feixas and M. Sbert, "Entropy-based adaptive sampling", Graphics Interface 2003: the entropy of an image is
that of its division plus the sum of q_r H_r, with q_r the share of region r in the image's value (grouping property),
so what a leaf contributes is q times its contrast, and the leaf that contributes most is refined. Here leaves are
pixels. A leaf's contrast is DELTA times that of colour plus 1 - DELTA times that of geometry; both are 0 to 1, as the
mean colour of equation 8 is in q: it is divided out of the first. A pixel is refined while q times contrast is above a
threshold, which is lowered until the budget is spent.
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
"""Weight of colour against geometry: the papers leave it to the user."""


@criterion("rigau", needs_radiance=True, spends="priority", moments=logarithms)
def rigau(evidence: Evidence) -> Floats:
    """Return q times contrast (H, W), times the number of pixels."""
    brightness = luminance(mean_colour(evidence))
    colour = divided(perceived(evidence, contrast_of(evidence)), brightness)
    contrast = DELTA * colour + (1.0 - DELTA) * evidence.complexity.geometry_contrast
    average = float(np.mean(brightness, where=np.isfinite(brightness))) if np.isfinite(brightness).any() else 0.0
    return ranked(brightness * contrast / (average if average > 0 else 1.0), evidence)
