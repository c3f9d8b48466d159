"""Which part of what a denoiser took away was no noise, and is given back.

Of two pictures with independent errors the mixture of least squared error weighs each by the squared error of the other
one. The residual, the noisy picture minus the denoised one, has the squared errors of both. So what of it is more than
noise may be is the denoiser's error, on average over some pixels, or in a single one where it is more by far. Where
noise may be the part q of a residual, q^1.5 of it is taken, and not q, as the noise is more likely to be less than
more. And a part is given back in any case, the more, the more samples there are: noise falls, while the error of a
denoiser stays.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter

from tracer.core.arrays import Singles
from tracer.denoising.noise import FEW, WINDOW

SURE = 9.0
"""A single pixel is believed, against its surroundings, from this multiple of its possible noise on."""
MOST = 8.0
"""Largest residual, in standard deviations of expected noise, that counts for other pixels."""
PRIOR, PRIOR_RATE = 0.05, 0.7
"""PRIOR: squared error of the denoised picture over that of the noisy one after FEW samples, by which something is
given back in any case. PRIOR_RATE: power of the number of samples with which it rises."""
TINY = np.float32(1e-20)
"""Squared error that divides nothing."""


def kept_share(residual: Singles, noise: Singles, ratio: Singles, count: Singles) -> Singles:
    """Return the share (H, W) of a ``residual`` (H, W, 3) that is to be given back, 0 to 1.

    ``noise`` (H, W): squared error expected of it if samples were independent; ``ratio`` (H, W): by what factor squared
    errors may exceed that and still be noise; ``count`` (H, W): samples.
    """
    squared = np.einsum("hwc,hwc->hw", residual, residual) / (3 * np.maximum(noise, TINY))
    around = uniform_filter(np.minimum(squared, np.float32(MOST**2)), WINDOW, mode="nearest")
    noise_part = np.minimum(ratio / np.maximum(around, TINY), 1.0)
    taken = np.minimum(noise_part * np.sqrt(noise_part), np.float32(SURE) * ratio / np.maximum(squared, TINY))
    prior = np.float32(PRIOR) * (count / np.float32(FEW)) ** np.float32(PRIOR_RATE)
    share: Singles = 1.0 - taken / (1.0 + prior)
    return share
