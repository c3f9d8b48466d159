"""Colour contrast: how unevenly the light of a pixel is shared among its samples, by Shannon's entropy.

J. Rigau, M. Feixas and M. Sbert, "New contrast measures for pixel supersampling", CGI 2002, and "Entropy-based adaptive
sampling", Graphics Interface 2003, equations 6 to 8. With p_i the shares of the N samples of a channel in their sum,
C = 1 - H / log N; channels are combined with the weights of luminance and the pixel's mean colour. A pixel is refined
while the contrast is above a threshold, which is lowered until the budget is spent. As published it depends on N: for a
pixel half black and half white it is 1 / log2 N, so that refinement by itself lowers it, if slowly.
"""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Floats
from tracer.criteria.colour import known, perceived, ranked
from tracer.criteria.divergences import kullback_leibler_of, logarithms
from tracer.criteria.registry import Evidence, criterion


def contrast_of(evidence: Evidence) -> Floats:
    """Return C (H, W, C) of each channel, 0 to 1, from ``logarithms``: ln N - H is the Kullback-Leibler divergence."""
    greatest_entropy = np.log(np.maximum(known(evidence).count, 2).astype(np.float64))
    return kullback_leibler_of(evidence) / greatest_entropy[..., None]


@criterion("colour_contrast", needs_radiance=True, spends="priority", moments=logarithms)
def colour_contrast(evidence: Evidence) -> Floats:
    """Return the colour contrast (H, W), 0 to the luminance of the pixel."""
    return ranked(perceived(evidence, contrast_of(evidence)), evidence)
