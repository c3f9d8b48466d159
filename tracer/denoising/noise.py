"""How noisy the mean of each pixel's own samples may be, at most: differences beyond that are not noise.

If samples are independent, the squared error of a mean is their variance over their number. This is wrong in two ways.
After few samples a pixel has often not yet seen what makes it noisy; so its surroundings count as well, the less, the
more samples there are. And the samples are stratified, so their mean errs by less than that of independent samples; the
advantage grows with their number and is largest where an edge runs through the pixel. On many_lights, thin_rods and the
public veach-mis the squared error was on average 0.8 to 2 times the variance over the number at 8 samples per pixel,
0.6 to 0.95 times at 32 and 0.4 to 1.2 times at 128.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter

from tracer.core.arrays import Singles
from tracer.denoising.neighbours import local_variance

WINDOW = 7
"""Side in pixels of the square over which squared errors are averaged."""
PRIOR_SAMPLES = 32.0
"""Number of samples of a pixel from which on its own variance tells more of its noise than its surroundings do."""
DARKEST = 0.01
"""Brightness, over that of most of the picture, that a pixel is taken to have at least."""
BRIGHTER = 2.0
"""Factor by which a pixel may be brighter than in the denoised picture."""
FEW = 8.0
"""Number of samples that the following constants, and those of ``tracer.denoising.trust``, belong to."""
ALLOWANCE = 3.0
"""Squared error of a mean of FEW samples, over that expected of independent samples, that may still be noise: it leaves
room for what few samples have not found."""
RATE = 0.4
"""Power of the number of samples with which ALLOWANCE falls, and rises for fewer than FEW."""
EDGE_FACTOR = 0.2
"""Factor of ALLOWANCE where all variance is that of an edge."""
EDGE_RATE = 0.5
"""Power of the number of samples, from FEW on, with which EDGE_FACTOR falls: how much of a pixel lies on which side of
an edge, n stratified samples tell with a squared error that falls as n^-1.5."""
TINY = np.float32(1e-20)
"""Least squared error or brightness that is divided by."""


def own_errors(mean: Singles, variance: Singles, count: Singles) -> Singles:
    """Return the squared standard errors (H, W, C) of means (H, W, C) from the variance of each pixel's own samples.

    A single sample does not tell its error, which is taken to be as large as the mean. ``count`` (H, W): samples.
    """
    errors: Singles = np.asarray(np.maximum(variance, 0.0) / np.maximum(count, 1.0)[..., None], np.float32)
    few = count <= 1.0
    errors[few] = np.square(mean[few])
    return errors


def expected_noise(grey: Singles, clean: Singles, squared_errors: Singles, count: Singles, median: float) -> Singles:
    """Return the squared error (H, W) that pixel means would have if their samples were independent.

    ``grey`` (H, W): the means, averaged over colours; ``clean`` (H, W): the same of the denoised picture;
    ``squared_errors`` (H, W): ``own_errors``, averaged over colours; ``count`` (H, W): samples; ``median``: brightness
    of the whole picture. Errors of surroundings count in proportion to brightness, or as they are if that is less, so
    that a lamp and its edge leave their surroundings alone.
    """
    level = np.square(grey) + np.float32((DARKEST * median) ** 2) + TINY
    # The squared error of a mean of samples that are not negative is at most the squared mean.
    relative = uniform_filter(np.minimum(squared_errors / level, np.float32(1)), WINDOW, mode="nearest")
    # What few samples have left dark by chance is as bright as the denoised picture, or as what is around.
    expected = np.maximum(np.square(clean), level)
    around = np.minimum(np.square(uniform_filter(grey, WINDOW, mode="nearest")), BRIGHTER**2 * expected)
    wide = np.minimum(uniform_filter(squared_errors, WINDOW, mode="nearest"), relative * np.maximum(expected, around))
    noise: Singles = np.maximum(squared_errors, wide * np.square(PRIOR_SAMPLES / (PRIOR_SAMPLES + count)))
    return noise


def possible_ratio(count: Singles, edge_share: Singles) -> Singles:
    """Return by what factor squared errors may exceed ``expected_noise`` and still be noise, (H, W).

    ``count`` (H, W): samples of each pixel; ``edge_share`` (H, W): what ``edge_share`` returned.
    """
    growth = np.log(np.maximum(uniform_filter(count, WINDOW, mode="nearest"), 1.0) / np.float32(FEW))
    at_edge = np.log(np.float32(EDGE_FACTOR)) - np.float32(EDGE_RATE) * np.maximum(growth, 0.0)
    ratio: Singles = np.float32(ALLOWANCE) * np.exp(edge_share * at_edge - np.float32(RATE) * growth)
    return ratio


def edge_share(clean: Singles, noise: Singles, count: Singles) -> Singles:
    """Return the share (H, W) of the variance of each pixel's samples that edges of the picture explain, 0 to 1.

    ``clean`` (H, W): the denoised picture, averaged over colours, whose variance from pixel to pixel is that of an edge
    within a pixel; ``noise`` (H, W): ``expected_noise``.
    """
    share: Singles = np.minimum(local_variance(clean) / np.maximum(noise * count, TINY), np.float32(1))
    return share
