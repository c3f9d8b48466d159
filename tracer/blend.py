"""A denoised picture where there is noise, and the picture as it was where there is none.

A denoiser blurs what is nearly clean: with enough samples its picture is the worse one. Of two estimates the best
mixture weighs each by the other's squared error. That of the picture is known, from its standard errors. That of the
denoised one shows in how much further apart the two are than noise alone would bring them, on average over some pixels.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter

from tracer import objective, score

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
SMOOTH = 3.0
"""Standard deviation in pixels over which squared errors are averaged."""
UNMEASURED = 0.5
"""Squared error over what standard errors say, where it was not measured: a stratified sequence errs by less."""
OVERSTATED = 0.65
"""By how much the largest of a pixel's and its neighbours' errors overstates its own."""
LEAST = 0.2
"""The same, at least: what is measured is the error of most pixels, not that of those which are worst."""


def blend(noisy: NDArray, clean: NDArray, stderr: NDArray, own: NDArray, scale: float | None) -> Singles:
    """Return the mixture of two pictures (H, W, 3) of least expected squared error, relative to the brightness.

    ``stderr`` (H, W, 3): standard errors of ``noisy``; ``own`` (H, W, 3): squared errors from each pixel's own samples
    alone, which know of fireflies. ``scale``: by which standard errors are to be multiplied (see ``tracer.noise``).
    """
    weight = objective.weights("relative", score.luminance(clean))
    known = UNMEASURED if scale is None else min(max(OVERSTATED * scale**2, LEAST), 1.0)
    by_error = weight * np.mean(np.square(stderr, dtype=np.float64), axis=-1)
    by_own = maximum_filter(weight * np.mean(own, axis=-1, dtype=np.float64), 3)
    noise = known * np.maximum(by_error, by_own)
    apart = weight * np.mean(np.square(noisy - clean, dtype=np.float64), axis=-1)
    blurred = np.maximum(gaussian_filter(apart - noise, SMOOTH), 0.0)
    total = blurred + gaussian_filter(noise, SMOOTH)
    share = np.divide(blurred, total, out=np.zeros_like(total), where=total > 0)[..., None]
    return (share * noisy + (1.0 - share) * clean).astype(np.float32)
