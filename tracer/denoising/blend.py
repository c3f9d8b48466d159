"""A denoised picture where there is noise, and the picture as it was where there is none.

A denoiser blurs what is nearly clean: with enough samples its picture is the worse one. Of two estimates the best
mixture weighs each by the other's squared error. That of the noisy one is known, from its standard errors. That of the
other shows in how much further apart the two are than noise alone would bring them: on average over some pixels, and in
a single pixel where they are so far apart that noise hardly ever does it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter

from tracer.core.arrays import Floats
from tracer.image import colour, objective

Singles = NDArray[np.float32]
SMOOTH = 3.0
"""Standard deviation in pixels over which squared errors are averaged."""
UNMEASURED = 0.5
"""Squared error over what standard errors say, where it was not measured: a stratified sequence errs by less."""
OVERSTATED = 0.65
"""By how much the largest of a pixel's and its neighbours' errors overstates its own."""
LEAST = 0.2
"""The same, at least: what is measured is the error of most pixels, not that of those which are worst."""
TYPICAL = 1.5
"""Mean square over geometric mean of the errors of pixels that are equally noisy, in colours that err alike: 1 to 3.6
for normal errors."""
SURE = 9.0
"""Times its expected squared noise from which on a single pixel is believed, against its surroundings."""
NEGLIGIBLE = 1e-12
"""Squared relative error that nobody sees."""


@dataclass(frozen=True)
class Errors:
    """What is known of the errors of a noisy picture: squared, relative to the brightness, each (H, W)."""

    weight: Floats
    """By which squared differences become relative ones."""
    stated: Floats
    """As standard errors say, and as the pixel's and its neighbours' own samples do."""
    loud: Floats
    """Of those of the pixel and its neighbours whose samples do not know how bright they are: fireflies."""
    telling: Floats
    """1 where the errors of a pixel say something of those around it, else 0."""
    least: float
    """Least and most part of what is stated that the squared errors are, on average over some pixels."""
    most: float

    def of(self, apart: NDArray) -> Floats:
        """Return squared relative differences (H, W) from differences (H, W, 3)."""
        mean: Floats = self.weight * np.mean(np.square(apart, dtype=np.float64), axis=-1)
        return mean


def errors_of(
    clean: NDArray,
    stderr: NDArray,
    own: NDArray,
    scale: float | None,
    certain: NDArray | None = None,
    telling: NDArray | None = None,
) -> Errors:
    """Return what is known of the errors of a picture whose brightness is about that of ``clean`` (H, W, 3).

    ``stderr`` (H, W, 3): its standard errors; ``own`` (H, W, 3): squared errors from each pixel's own samples alone,
    which know of fireflies. ``scale``: by which standard errors are to be multiplied, see
    ``tracer.adaptive.convergence``; None: that is not known. ``certain`` (H, W): whose samples know how bright the
    pixel is; none, by default. ``telling`` (H, W): see ``Errors``; all of them, by default.
    """
    weight = objective.weights("relative", colour.luminance(clean))
    by_error, by_own = (
        weight * np.mean(each, axis=-1, dtype=np.float64) for each in (np.square(stderr, dtype=np.float64), own)
    )
    stated = np.maximum(by_error, maximum_filter(by_own, 3))
    loud = stated if certain is None else maximum_filter(np.where(certain, 0.0, by_own), 3)
    measured = LEAST if scale is None else min(OVERSTATED * scale**2, 1.0)
    most = UNMEASURED if scale is None else max(measured, LEAST)
    told = np.ones_like(weight) if telling is None else telling.astype(np.float64)
    # Parts of a picture may be as much better than all of it as that is better than what was stated.
    return Errors(weight, stated, loud, told, measured**2, most)


def share_of_noisy(apart: NDArray, errors: Errors, part: float = 1.0) -> Floats:
    """Return which share of a difference (H, W, 3) of two pictures to keep (H, W, 1), 0 to 1: what is not noise.

    ``part``: of the squared errors, how much of them is in the difference. Noise is at most what most pixels around are
    apart by, but for fireflies.
    """
    difference, told = errors.of(apart), errors.telling
    ratio = np.log(np.maximum(difference, NEGLIGIBLE) / np.maximum(part * errors.stated, NEGLIGIBLE))
    mean = gaussian_filter(told * ratio, SMOOTH) / np.maximum(gaussian_filter(told, SMOOTH), NEGLIGIBLE)
    known = np.clip(TYPICAL * np.exp(mean), errors.least, errors.most)
    noise = part * np.maximum(known * errors.stated, errors.most * errors.loud)
    excess = np.maximum(gaussian_filter(told * (difference - noise), SMOOTH), 0.0)
    total = excess + gaussian_filter(told * noise, SMOOTH)
    around = np.divide(excess, total, out=np.zeros_like(total), where=total > 0)
    alone = 1.0 - np.minimum(SURE * noise / np.maximum(difference, NEGLIGIBLE), 1.0)
    share: Floats = np.maximum(around, alone)[..., None]
    return share


def blend(noisy: NDArray, clean: NDArray, errors: Errors, part: float = 1.0) -> Singles:
    """Return the mixture of two pictures (H, W, 3) of least expected squared error, relative to the brightness.

    ``errors`` are those of ``noisy``; ``part`` of them is what the pictures differ by but for what ``clean`` misses.
    """
    apart = np.subtract(noisy, clean, dtype=np.float64)
    mixed: Singles = (clean + share_of_noisy(apart, errors, part) * apart).astype(np.float32)
    return mixed
