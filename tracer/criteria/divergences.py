"""f-divergences of a pixel's samples, taken as shares of their sum, from uniform shares; and their square roots.

J. Rigau, M. Feixas and M. Sbert, "Refinement criteria based on f-divergences", EGSR 2003. With c_i the N samples of a
channel and p_i = c_i / sum c:

    Kullback-Leibler  sum p_i ln(N p_i)       = mean(c ln c) / mean(c) - ln mean(c)
    chi-square        N sum p_i^2 - 1         = mean((c - mean(c))^2) / mean(c)^2
    Hellinger         1 - sum sqrt(p_i / N)   = 1 - mean(sqrt c) / sqrt(mean(c))

The criterion is (1 / N) sum_k w_k c_k D_k / sum_k w_k over channels, or the same with sqrt(D_k). A pixel is refined
while the criterion is above a threshold, which is lowered until the budget is spent. D is like a variance and its root
like a standard deviation, and it is best to draw samples in proportion to the latter. The right-hand sides need means
alone, and no list of samples.
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


def logarithms(colour: list[mi.Float], index: mi.UInt32) -> Sums:
    """Ask for the mean of c ln c per channel."""
    return [dr.select(c > 0, c * dr.log(c), 0.0) for c in colour], []


def roots(colour: list[mi.Float], index: mi.UInt32) -> Sums:
    """Ask for the mean of sqrt(c) per channel."""
    return [dr.sqrt(dr.maximum(c, 0.0)) for c in colour], []


def kullback_leibler_of(evidence: Evidence) -> Floats:
    """Return the Kullback-Leibler divergence (H, W, C) in nats, from ``logarithms``; 0 to ln N."""
    mean, mean_of_logarithms = mean_colour(evidence), colours(known(evidence).moments, evidence.colour_channels)
    logarithm = np.log(mean, out=np.zeros_like(mean), where=mean > 0)
    divergence = np.where(mean > 0, divided(mean_of_logarithms, mean) - logarithm, 0.0)
    return beyond_rounding(divergence, evidence, 1.0 + np.abs(logarithm))


def chi_square_of(evidence: Evidence) -> Floats:
    """Return the chi-square divergence (H, W, C), from mean and variance; 0 to N - 1."""
    mean, count = mean_colour(evidence), known(evidence).count[..., None].astype(np.float64)
    largest = np.maximum(count - 1.0, 0.0)
    squared_deviation = colours(known(evidence).variance, evidence.colour_channels) * divided(largest, count)
    return np.minimum(divided(squared_deviation, mean**2), largest)  # only negative samples bring it above N - 1


def hellinger_of(evidence: Evidence) -> Floats:
    """Return the Hellinger divergence (H, W, C), from ``roots``; 0 to 1 - 1 / sqrt N."""
    mean, mean_of_roots = mean_colour(evidence), colours(known(evidence).moments, evidence.colour_channels)
    return beyond_rounding(np.where(mean > 0, 1.0 - divided(mean_of_roots, np.sqrt(mean)), 0.0), evidence)


def refinement(evidence: Evidence, divergence: Floats) -> Floats:
    """Return the criterion (H, W) of a divergence or its root (H, W, C)."""
    return ranked(perceived(evidence, divergence) / np.maximum(known(evidence).count, 1), evidence)


@criterion("kullback_leibler", needs_radiance=True, spends="priority", moments=logarithms)
def kullback_leibler(evidence: Evidence) -> Floats:
    """Return the criterion (H, W) of the Kullback-Leibler divergence."""
    return refinement(evidence, kullback_leibler_of(evidence))


@criterion("chi_square", needs_radiance=True, spends="priority")
def chi_square(evidence: Evidence) -> Floats:
    """Return the criterion (H, W) of the chi-square divergence."""
    return refinement(evidence, chi_square_of(evidence))


@criterion("hellinger", needs_radiance=True, spends="priority", moments=roots)
def hellinger(evidence: Evidence) -> Floats:
    """Return the criterion (H, W) of the Hellinger divergence."""
    return refinement(evidence, hellinger_of(evidence))


@criterion("root_kullback_leibler", needs_radiance=True, spends="priority", moments=logarithms)
def root_kullback_leibler(evidence: Evidence) -> Floats:
    """Return the criterion (H, W) of the root of the Kullback-Leibler divergence."""
    return refinement(evidence, np.sqrt(kullback_leibler_of(evidence)))


@criterion("root_chi_square", needs_radiance=True, spends="priority")
def root_chi_square(evidence: Evidence) -> Floats:
    """Return the criterion (H, W) of the root of the chi-square divergence."""
    return refinement(evidence, np.sqrt(chi_square_of(evidence)))


@criterion("root_hellinger", needs_radiance=True, spends="priority", moments=roots)
def root_hellinger(evidence: Evidence) -> Floats:
    """Return the criterion (H, W) of the root of the Hellinger divergence."""
    return refinement(evidence, np.sqrt(hellinger_of(evidence)))
