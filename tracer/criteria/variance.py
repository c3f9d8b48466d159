"""Radiance alone: the standard deviation of samples, smoothed over a pixel's neighbours.

Neyman's allocation (1934): n_i proportional to s_i sqrt(w_i) minimises sum w_i s_i^2 / n_i.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter

from tracer.core.arrays import Floats
from tracer.criteria.registry import Evidence, criterion
from tracer.film.estimate import Statistics

RADIUS = 1.0
"""Standard deviation, in pixels, of the Gaussian that smooths variances: from few samples they are mostly noise."""


def colour_variance(statistics: Statistics, channels: int) -> Floats:
    """Return the variance of one sample (H, W), averaged over colour channels."""
    return statistics.variance[..., :channels].mean(axis=-1)


@criterion("variance", needs_radiance=True, spends="deviation")
def variance(evidence: Evidence) -> Floats:
    """Return s sqrt(w) (H, W), with s^2 w smoothed."""
    assert evidence.statistics is not None
    weighted = colour_variance(evidence.statistics, evidence.colour_channels) * evidence.weight
    return np.sqrt(gaussian_filter(weighted, RADIUS, mode="nearest"))
