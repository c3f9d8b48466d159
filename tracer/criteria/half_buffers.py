"""The difference between the mean of all samples and the mean of half of them, which production renderers use.

H. Dammertz, J. Hanika, A. Keller and H. Lensch, "A hierarchical automatic stopping condition for Monte Carlo global
illumination", WSCG 2010, per pixel as in Blender Cycles (``film/adaptive_sampling.h``, 2026) and in Mitsuba 3's pull
request 1731, integrator ``adaptive_sampling`` (2025). With the mean I of all samples and the mean A of the half,

    E = sum_c |I_c - A_c| / (1e-4 + g(sum_c I_c)),   g(x) = sqrt(x) for x < 1, else x

for an exposure of 1. A pixel goes on while E of any of its 3 x 3 neighbours is above a threshold. Here the threshold is
lowered until the budget is spent, so a pixel counts with the largest E around it. In both programs a pixel that has
stopped never goes on again, except by a neighbour in Cycles; here all pixels are judged anew in each round.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import drjit as dr
import numpy as np
from scipy.ndimage import maximum_filter

from tracer.core.arrays import Floats
from tracer.criteria.colour import Sums, colours, divided, grey_as_rgb, known, ranked
from tracer.criteria.registry import Evidence, criterion

if TYPE_CHECKING:
    import mitsuba as mi

EPSILON = 1e-4
"""Term in the denominator of E that keeps the error of black pixels finite."""
FILTER_SIZE = 3
"""Side in pixels of the window over which the largest E counts."""
CLASS_BITS = 0xAAAAAAAA
"""The odd places of a 32-bit index."""


def half(colour: list[mi.Float], chosen: mi.Bool) -> Sums:
    """Ask for the mean colour of chosen samples, with others as 0, and for the share of chosen samples."""
    unit = type(colour[0])(1.0)
    return [dr.select(chosen, quantity, 0.0) for quantity in (*colour, unit)], []


def class_a(colour: list[mi.Float], index: mi.UInt32) -> Sums:
    """Choose class A of Cycles: samples whose index has an odd number of ones at odd places.

    Each class is well distributed by itself (P. Christensen, A. Kensler and C. Kilpatrick, "Progressive
    multi-jittered sample sequences", EGSR 2018, section 10.2.1).
    """
    return half(colour, (dr.popcnt(index & CLASS_BITS) & 1) == 1)


def even(colour: list[mi.Float], index: mi.UInt32) -> Sums:
    """Choose every other sample, from the first on."""
    return half(colour, (index & 1) == 0)


def half_buffer_error(evidence: Evidence) -> Floats:
    """Return the largest E of 3 x 3 pixels (H, W).

    The sum of the half is divided by its own number of samples, as in the pull request; Cycles takes it to be half of
    all samples, and looks only when it is. A pixel with no sample or with all its samples in the half has no error yet
    and counts as the worst.
    """
    statistics, channels = known(evidence), evidence.colour_channels
    share = statistics.moments[..., channels].astype(np.float64)
    mean = grey_as_rgb(colours(statistics.mean, channels))
    half_mean = grey_as_rgb(divided(colours(statistics.moments, channels), share[..., None].repeat(channels, axis=-1)))
    intensity = np.maximum(mean.sum(axis=-1), 0.0)
    scale = EPSILON + np.where(intensity < 1, np.sqrt(intensity), intensity)
    error = np.abs(mean - half_mean).sum(axis=-1) / scale
    error = ranked(np.where((share > 0) & (share < 1), error, np.nan), evidence)
    return maximum_filter(error, FILTER_SIZE, mode="nearest")


@criterion("cycles", needs_radiance=True, spends="priority", moments=class_a)
def cycles(evidence: Evidence) -> Floats:
    """Return the error (H, W) by the half that Cycles takes."""
    return half_buffer_error(evidence)


@criterion("mitsuba_1731", needs_radiance=True, spends="priority", moments=even)
def mitsuba_1731(evidence: Evidence) -> Floats:
    """Return the error (H, W) by every other sample, with the centred filter that the pull request means to have."""
    return half_buffer_error(evidence)
