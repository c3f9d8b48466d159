"""A denoised picture where there is noise, and the picture as it was where there is none.

A denoiser blurs what is nearly clean: with enough samples its picture is worse than the noisy one. The best mixture of
two estimates weighs each by the squared error of the other. The error of the noisy picture is known from its standard
errors. The error of the denoised one is what noise alone does not explain of the difference between the two: on average
over some pixels, and in a single pixel where they are so far apart that noise hardly ever does it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter

from tracer.core.arrays import Floats, Singles
from tracer.image import colour, objective

SMOOTH = 3.0
"""Standard deviation in pixels over which squared errors are averaged."""
UNMEASURED = 0.5
"""Squared error over the squared standard error, where it was not measured: a stratified sequence errs by less."""
OVERSTATED = 0.65
"""Squared error of a pixel over the largest of its own and its neighbours', by which it is estimated."""
LEAST = 0.2
"""Least value for that ratio if it was measured: the measurement tells the error of most pixels, not of the worst."""
TYPICAL = 1.5
"""Mean square over geometric mean of the squared errors of equally noisy pixels, in colours that err alike. For normal
errors the ratio is 1 to 3.6."""
SURE = 9.0
"""A single pixel is believed, against its surroundings, from this multiple of its expected squared noise on."""
NEGLIGIBLE = 1e-12
"""Squared relative error that nobody sees; smaller ones are raised to it."""


@dataclass(frozen=True)
class Errors:
    """What is known of the errors of a noisy picture: squared and relative to the brightness, (H, W) each."""

    weight: Floats
    """Factor that makes squared differences relative to the squared brightness."""
    stated: Floats
    """Squared error by standard errors or, if that is larger, by the own samples of the pixel and its neighbours."""
    loud: Floats
    """Largest squared error among the pixel and its neighbours that are fireflies: their samples tell no brightness."""
    telling: Floats
    """1 where the error of a pixel says something about the errors around it, else 0."""
    least: float
    """Least ratio of squared errors to those stated, on average over some pixels."""
    most: float
    """Largest such ratio."""

    def of(self, apart: NDArray) -> Floats:
        """Return squared relative differences (H, W) from differences (H, W, 3)."""
        mean: Floats = self.weight * np.mean(np.square(apart, dtype=np.float64), axis=-1)
        return mean


def errors_of(
    clean: NDArray,
    stderr: NDArray,
    own_squares: NDArray,
    scale: float | None,
    certain: NDArray | None = None,
    telling: NDArray | None = None,
) -> Errors:
    """Return what is known of the errors of a picture whose brightness is about that of ``clean`` (H, W, 3).

    ``stderr`` (H, W, 3): its standard errors; ``own_squares`` (H, W, 3): squared errors from each pixel's own samples
    alone, which show fireflies. ``scale``: measured factor of the standard errors, see ``tracer.adaptive.convergence``;
    None: not measured. ``certain`` (H, W): pixels whose samples tell their brightness; None: no pixel. ``telling``
    (H, W): see ``Errors``; None: all pixels.
    """
    weight = objective.weights("relative", colour.luminance(clean))
    by_error, by_own = (
        weight * np.mean(squares, axis=-1, dtype=np.float64)
        for squares in (np.square(stderr, dtype=np.float64), own_squares)
    )
    stated = np.maximum(by_error, maximum_filter(by_own, 3))
    loud = stated if certain is None else maximum_filter(np.where(certain, 0.0, by_own), 3)
    measured = LEAST if scale is None else min(OVERSTATED * scale**2, 1.0)
    greatest_ratio = UNMEASURED if scale is None else max(measured, LEAST)
    is_telling = np.ones_like(weight) if telling is None else telling.astype(np.float64)
    # Parts of a picture may be better than the whole by as much as the whole is better than stated.
    return Errors(weight, stated, loud, is_telling, measured**2, greatest_ratio)


def share_of_noisy(apart: NDArray, errors: Errors, part: float = 1.0) -> Floats:
    """Return the share of a difference ``apart`` (H, W, 3) of two pictures that is not noise, (H, W, 1), 0 to 1.

    ``part``: part of the squared errors that is in the difference. Except for fireflies, the noise of a pixel is taken
    to be at most the difference of most pixels around it.
    """
    difference, telling = errors.of(apart), errors.telling
    ratio = np.log(np.maximum(difference, NEGLIGIBLE) / np.maximum(part * errors.stated, NEGLIGIBLE))
    mean = gaussian_filter(telling * ratio, SMOOTH) / np.maximum(gaussian_filter(telling, SMOOTH), NEGLIGIBLE)
    measured_ratio = np.clip(TYPICAL * np.exp(mean), errors.least, errors.most)
    noise = part * np.maximum(measured_ratio * errors.stated, errors.most * errors.loud)
    excess = np.maximum(gaussian_filter(telling * (difference - noise), SMOOTH), 0.0)
    total = excess + gaussian_filter(telling * noise, SMOOTH)
    around = np.divide(excess, total, out=np.zeros_like(total), where=total > 0)
    alone = 1.0 - np.minimum(SURE * noise / np.maximum(difference, NEGLIGIBLE), 1.0)
    share: Floats = np.maximum(around, alone)[..., None]
    return share


def blend(noisy: NDArray, clean: NDArray, errors: Errors, part: float = 1.0) -> Singles:
    """Return the mixture of two pictures (H, W, 3) of least expected squared error, relative to the brightness.

    ``errors``: those of ``noisy``; ``part``: the part of them that is in the difference of the pictures, apart from the
    error of ``clean``.
    """
    apart = np.subtract(noisy, clean, dtype=np.float64)
    mixed: Singles = (clean + share_of_noisy(apart, errors, part) * apart).astype(np.float32)
    return mixed
