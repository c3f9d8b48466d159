"""Pixels far brighter than what surrounds them, and certainly so: small lamps, their mirror images, bright rods.

Open Image Denoise takes a bright pixel that stands alone for a firefly and wipes it out, makes a lamp of a few pixels
up to half as bright again, and lets both bleed into what is around: of a picture with lamps some thousand times
brighter than the rest, a fifth of the brightness goes. So they are taken out of what it is given, and stay as they were
drawn. What tells a lamp from a firefly is the pixel's own standard error: that of a firefly is as large as its mean.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, grey_opening, maximum_filter, median_filter, uniform_filter

from tracer.image import colour

Mask = NDArray[np.bool_]
CONTRAST = 30.0
"""Times its surroundings from which on a lamp is smeared: at 30 by 2 % of itself, at 300 by 10, at 3,000 by 40."""
MEAN_CONTRAST = 8.0
"""The same over the mean of a wide window, in which light that few samples find has its part."""
SMALL, WIDE = 15, 31
"""Pixels a side: what holds a square of the first is not small; the window of the mean."""
CERTAIN, LEAST_COUNT = 5.0**0.5, 4
"""Standard errors of its own that a pixel is bright, and samples that know them: of light that few samples find, hardly
ever do enough fall into one pixel."""
ALL_AROUND = np.ones((3, 3), bool)


@dataclass(frozen=True)
class Outliers:
    """What stands out of a picture of means, all (H, W)."""

    mask: Mask
    """Which pixels stand out."""
    certain: Mask
    """Which pixels are certainly as bright as they are, about."""


def own_errors(mean: NDArray, variance: NDArray, count: NDArray) -> NDArray:
    """Return the squared standard errors (H, W, C) of means (H, W, C) from the variance of each pixel's own samples.

    One sample knows nothing of its error: it is taken for as large as the mean. ``count`` (H, W).
    """
    samples = count[..., None]
    return np.where(samples > 1, np.maximum(variance, 0.0) / np.maximum(samples, 1), np.square(mean))


def find_outliers(mean: NDArray, own: NDArray, count: NDArray) -> Outliers:
    """Return what stands out of ``mean`` (H, W, 3), means of each pixel's ``count`` (H, W) samples alone.

    ``own`` (H, W, 3): squared standard errors, from these samples alone. Bright pixels that touch certain ones belong
    to them: the edge of a lamp, which few samples of a pixel see.
    """
    brightness = colour.luminance(mean)
    squared, error = (np.mean(each, axis=-1, dtype=np.float64) for each in (np.square(mean), own))
    certain = (count >= LEAST_COUNT) & (squared >= CERTAIN**2 * error)
    opened = grey_opening(median_filter(brightness, 3, mode="nearest"), SMALL, mode="nearest")
    around = np.maximum(opened, MEAN_CONTRAST / CONTRAST * uniform_filter(brightness, WIDE, mode="nearest"))
    standing = certain & (brightness > CONTRAST * np.maximum(around, 0.0))
    beside = binary_dilation(standing, ALL_AROUND) & (brightness > CONTRAST * np.maximum(opened, 0.0))
    return Outliers(standing | beside, certain)


def taken_out(mean: NDArray, outliers: Outliers) -> NDArray:
    """Return ``mean`` (H, W, 3) with the mean of what is around in place of what stands out."""
    stays = (~outliers.mask).astype(np.float64)[..., None]
    total, share = (uniform_filter(each, (SMALL, SMALL, 1), mode="nearest") for each in (stays * mean, stays))
    around = np.divide(total, share, out=np.zeros_like(total), where=share > 0.5 / SMALL**2)
    return np.where(outliers.mask[..., None], around, mean)


def within_reach(mean: NDArray, image: NDArray, outliers: Outliers, reach: int) -> Mask:
    """Return which pixels (H, W) of ``image`` are to stay as they are, for what stands out less than ``reach`` away.

    These are also pixels beside certain ones that are as much brighter: at the edge of a large lamp.
    """
    spread = maximum_filter(outliers.mask, 2 * reach + 1)
    brightest = maximum_filter(np.where(outliers.certain, colour.luminance(mean), 0.0), 2 * reach + 3)
    return spread | (brightest > CONTRAST * np.maximum(colour.luminance(image), 0.0))
