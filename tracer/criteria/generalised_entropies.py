"""Pixel quality by generalised entropies of a pixel's samples, taken as shares p_i = c_i / sum c of their sum.

Q. Xu, M. Sbert et al., "A new adaptive sampling technique for Monte Carlo global illumination" (Tsallis) and Q. Xu,
R. Hu, L. Xing and Y. Xu, "Adaptive sampling with Renyi entropy in Monte Carlo path tracing": quality is the entropy
over the largest entropy that N samples can have,

    Tsallis  S = (1 - sum p^q) / (q - 1),   at most (1 - N^(1 - q)) / (q - 1)
    Renyi    R = ln(sum p^a) / (1 - a),     at most ln N

and 1 - quality takes the place of Rigau's contrast (``colour_contrast``): it is combined over channels with the weights
of luminance and the pixel's mean colour, and compared with a threshold, which is lowered until the budget is spent.
Both need only mean(c^q), as sum p^q = N^(1 - q) mean(c^q) / mean(c)^q.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import drjit as dr
import numpy as np

from tracer.core.arrays import Floats
from tracer.criteria.colour import Sums, beyond_rounding, colours, divided, known, mean_colour, perceived, ranked
from tracer.criteria.registry import Evidence, criterion

if TYPE_CHECKING:
    import mitsuba as mi

INDEX = 2.0
"""The index q of Tsallis and the order a of Renyi, which must not be 1. The papers fit it to their scenes; with 2 the
entropy is a function of the relative variance."""


def powers(colour: list[mi.Float], index: mi.UInt32) -> Sums:
    """Ask for the mean of c^INDEX per channel."""
    return [dr.power(dr.maximum(c, 0.0), INDEX) for c in colour], []


def excess(evidence: Evidence) -> Floats:
    """Return mean(c^q) / mean(c)^q - 1 (H, W, C), for q > 1: 0 if all samples are equal, and at most N^(q - 1) - 1."""
    mean, mean_of_powers = mean_colour(evidence), colours(known(evidence).moments, evidence.colour_channels)
    return beyond_rounding(np.where(mean > 0, divided(mean_of_powers, mean**INDEX) - 1.0, 0.0), evidence, INDEX)


def samples(evidence: Evidence) -> Floats:
    """Return N (H, W, 1), at least 2, as the entropy of a single sample says nothing."""
    return np.maximum(known(evidence).count, 2)[..., None].astype(np.float64)


def lack_of_tsallis(evidence: Evidence) -> Floats:
    """Return 1 - S / S_max (H, W, C)."""
    return excess(evidence) / (samples(evidence) ** (INDEX - 1.0) - 1.0)


def lack_of_renyi(evidence: Evidence) -> Floats:
    """Return 1 - R / R_max (H, W, C)."""
    return np.log1p(excess(evidence)) / ((INDEX - 1.0) * np.log(samples(evidence)))


@criterion("tsallis", needs_radiance=True, spends="priority", moments=powers)
def tsallis(evidence: Evidence) -> Floats:
    """Return the lack of quality (H, W) by Tsallis entropy, 0 to the luminance of the pixel."""
    return ranked(perceived(evidence, lack_of_tsallis(evidence)), evidence)


@criterion("renyi", needs_radiance=True, spends="priority", moments=powers)
def renyi(evidence: Evidence) -> Floats:
    """Return the lack of quality (H, W) by Renyi entropy, 0 to the luminance of the pixel."""
    return ranked(perceived(evidence, lack_of_renyi(evidence)), evidence)
