"""The test of Mitsuba 0.6: how certain the mean of a pixel is, relative to its brightness.

In the integrator ``adaptive`` of Mitsuba 0.6 (``src/integrators/misc/adaptive.cpp``) a pixel stops when the half width
of the confidence interval of its luminance, z sqrt(s^2 / n), is at most 5 % of max(mean, 1 % of the image's mean), with
the image's mean from 10 000 samples before the render. Here the image's mean is that of all samples so far, and the
5 % are changed until the budget is spent. z is that of Mitsuba's p-value of 0.05; it does not change the order of
pixels.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tracer.core.arrays import Floats
from tracer.criteria.colour import Sums, beyond_rounding, colours, divided, known, ranked
from tracer.criteria.registry import Evidence, criterion
from tracer.image.colour import LUMINANCE, luminance

if TYPE_CHECKING:
    import mitsuba as mi

Z = 1.959964
"""Two-sided quantile of a normal distribution for a p-value of 0.05."""
DARKEST = 0.01
"""Part of the image's mean luminance by which darker pixels are judged, so that they do not ask for more and more."""


def squared_luminance(colour: list[mi.Float], index: mi.UInt32) -> Sums:
    """Ask for the mean of the squared luminance."""
    if len(colour) == 1:
        return [colour[0] * colour[0]], []
    luminance_of_sample = sum(float(weight) * c for weight, c in zip(LUMINANCE, colour, strict=True))
    return [luminance_of_sample * luminance_of_sample], []


@criterion("z_test", needs_radiance=True, spends="priority", moments=squared_luminance)
def z_test(evidence: Evidence) -> Floats:
    """Return z sqrt(s^2 / n) / max(mean, 1 % of the image's mean) (H, W)."""
    statistics, channels = known(evidence), evidence.colour_channels
    count = np.maximum(statistics.count, 2).astype(np.float64)
    mean = luminance(colours(statistics.mean, channels))
    # The variance of luminance does not follow from the variances of the channels, as channels are correlated.
    squared = colours(statistics.moments, 1)
    variance = beyond_rounding(squared - mean[..., None] ** 2, evidence, squared)[..., 0]
    scale = np.maximum(mean, DARKEST * float(np.mean(mean, where=np.isfinite(mean))))
    return ranked(divided(Z * np.sqrt(variance / (count - 1.0)), scale), evidence)
