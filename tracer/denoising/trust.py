"""Which part of what a denoiser took away was no noise, and is given back.

The best mixture of two pictures with independent errors weighs each picture by the squared error of the other. The
residual, which is the noisy picture minus the denoised one, contains the squared errors of both. So the part of its
square that cannot be noise is the denoiser's error. It is measured over the pixels around, and in a single pixel where
it is far larger than noise. Where noise may be the part q of the square, q^1.5 of the residual is taken and not q, as
noise is more likely to be less than it may be. And a small part is given back in any case. It grows as noise falls,
which the error of a denoiser hardly does: with the number of samples, and where noise is so weak that nobody sees it.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter

from tracer.core.arrays import Singles
from tracer.denoising.noise import FEW, TINY, WINDOW

ALONE = 9.0
"""Multiple of its possible noise from which on the square of a single pixel's residual is more than noise, whatever is
around it."""
MOST_DEVIATIONS = 8.0
"""Largest residual, in standard deviations of expected noise, that counts for other pixels."""
PRIOR_ERROR = 0.05
"""Squared error of a denoised picture over that of the noisy one, after FEW samples, that is expected in any case."""
PRIOR_RATE = 0.7
"""Power of the number of samples with which PRIOR_ERROR rises."""
SEEN = 0.01
"""Least difference in brightness that is seen, over the brightness. Of noise as weak as that half is left."""
LARGEST_RATIO = np.float32(1e6)
"""Largest ratio that is squared."""


def kept_share(residual: Singles, noise: Singles, ratio: Singles, count: Singles, brightness: Singles) -> Singles:
    """Return the share (H, W) of a ``residual`` (H, W, 3) that is to be given back, 0 to 1.

    ``noise`` (H, W): squared error expected of it if samples were independent; ``ratio`` (H, W): by what factor squared
    errors may exceed that and still be noise; ``count`` (H, W): samples; ``brightness`` (H, W): that of the denoised
    picture.
    """
    squared = np.einsum("hwc,hwc->hw", residual, residual) / (3 * np.maximum(noise, TINY))
    around = uniform_filter(np.minimum(squared, np.float32(MOST_DEVIATIONS**2)), WINDOW, mode="nearest")
    noise_part = np.minimum(ratio / np.maximum(around, TINY), 1.0)
    taken = np.minimum(noise_part * np.sqrt(noise_part), np.float32(ALONE) * ratio / np.maximum(squared, TINY))
    prior = np.float32(PRIOR_ERROR) * (count / np.float32(FEW)) ** np.float32(PRIOR_RATE)
    likely_noise = np.maximum(noise * np.minimum(ratio, np.float32(1)), TINY)
    prior += np.square(np.minimum(np.float32(SEEN) * abs(brightness) / np.sqrt(likely_noise), LARGEST_RATIO))
    share: Singles = 1.0 - taken / (1.0 + prior)
    return share
