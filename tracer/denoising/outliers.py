"""Pixels that are certainly far brighter than their surroundings: small lamps, their mirror images, bright rods.

Open Image Denoise takes a bright pixel that stands alone for a firefly and wipes it out, makes a lamp of a few pixels
up to half as bright again, and lets both bleed into their surroundings: a picture with lamps some thousand times
brighter than the rest loses a fifth of its brightness. So such pixels are taken out of its input, and stay in the
picture as they were drawn. A pixel's own standard error tells a lamp from a firefly: a firefly's is as large as its
mean.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, grey_opening, maximum_filter, median_filter, uniform_filter

from tracer.core.arrays import Mask
from tracer.image import colour

CONTRAST = 30.0
"""Least brightness of an outlier, in multiples of its surroundings. From here on a lamp is smeared: at 30 times by 2 %
of itself, at 300 times by 10 %, at 3,000 times by 40 %."""
MEAN_CONTRAST = 8.0
"""Least brightness of an outlier in multiples of a wide window's mean, which includes light that few samples find."""
SMALL, WIDE = 15, 31
"""SMALL: side in pixels of the least square that is too large to be an outlier. WIDE: side of the wide window."""
CERTAIN, LEAST_COUNT = 5.0**0.5, 4
"""CERTAIN: least brightness of a certain pixel, in its own standard errors. LEAST_COUNT: least samples that tell these
errors: where few samples find light, hardly ever do that many fall into one pixel."""
ALL_AROUND = np.ones((3, 3), bool)
"""A pixel and its eight neighbours."""


@dataclass(frozen=True)
class Outliers:
    """Which pixels stand out of a picture of means, (H, W) each."""

    mask: Mask
    """Which pixels stand out."""
    certain: Mask
    """Which pixels are certainly about as bright as they appear."""


def own_errors(mean: NDArray, variance: NDArray, count: NDArray) -> NDArray:
    """Return the squared standard errors (H, W, C) of means (H, W, C) from the variance of each pixel's own samples.

    A single sample does not tell its error, which is taken to be as large as the mean. ``count`` (H, W): samples.
    """
    sample_count = count[..., None]
    return np.where(sample_count > 1, np.maximum(variance, 0.0) / np.maximum(sample_count, 1), np.square(mean))


def find_outliers(mean: NDArray, own_squares: NDArray, count: NDArray) -> Outliers:
    """Return which pixels stand out of ``mean`` (H, W, 3), the means of each pixel's own ``count`` (H, W) samples.

    ``own_squares`` (H, W, 3): squared standard errors from these samples alone. Bright pixels that touch certain
    outliers count as outliers, too: they are the edge of a lamp, which few of their samples see.
    """
    brightness = colour.luminance(mean)
    squared, error = (np.mean(values, axis=-1, dtype=np.float64) for values in (np.square(mean), own_squares))
    certain = (count >= LEAST_COUNT) & (squared >= CERTAIN**2 * error)
    opened = grey_opening(median_filter(brightness, 3, mode="nearest"), SMALL, mode="nearest")
    around = np.maximum(opened, MEAN_CONTRAST / CONTRAST * uniform_filter(brightness, WIDE, mode="nearest"))
    standing = certain & (brightness > CONTRAST * np.maximum(around, 0.0))
    beside = binary_dilation(standing, ALL_AROUND) & (brightness > CONTRAST * np.maximum(opened, 0.0))
    return Outliers(standing | beside, certain)


def taken_out(mean: NDArray, outliers: Outliers) -> NDArray:
    """Return ``mean`` (H, W, 3) with every outlier replaced by the mean of the other pixels around it."""
    stays = (~outliers.mask).astype(np.float64)[..., None]
    total, share = (uniform_filter(values, (SMALL, SMALL, 1), mode="nearest") for values in (stays * mean, stays))
    around = np.divide(total, share, out=np.zeros_like(total), where=share > 0.5 / SMALL**2)
    return np.where(outliers.mask[..., None], around, mean)


def within_reach(mean: NDArray, image: NDArray, outliers: Outliers, reach: int) -> Mask:
    """Return which pixels (H, W) of ``image`` are to stay as they are, as outliers lie at most ``reach`` pixels away.

    Pixels near certain ones that are more than CONTRAST times as bright stay, too: at the edge of a large lamp.
    """
    spread = maximum_filter(outliers.mask, 2 * reach + 1)
    brightest = maximum_filter(np.where(outliers.certain, colour.luminance(mean), 0.0), 2 * reach + 3)
    return spread | (brightest > CONTRAST * np.maximum(colour.luminance(image), 0.0))
