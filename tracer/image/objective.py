"""Which error is to be small: the weight w of each pixel's variance in the sum that an allocation minimises."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

Objective = Literal["absolute", "relative", "display", "denoised"]
OBJECTIVES: tuple[str, ...] = get_args(Objective)
EPSILON = 0.01
"""Added to the squared luminance, as it is seen, in relative errors, so that black pixels do not take everything."""


def weights(objective: str, luminance: ArrayLike, exposure: float = 0.0) -> NDArray[np.float64]:
    """Return w >= 0 for pixels of mean ``luminance`` (any shape): the squared error as seen over that of the radiance.

    Every objective judges the picture that ``exposure``, in stops, makes: s = 2^exposure times the radiance. So a scene
    of half the light at one stop more has the same errors. With the seen luminance L = s luminance, w is s^2 times

    absolute: 1, the error of the exposed radiance. relative: 1 / (L^2 + EPSILON). display: the squared slope of the
    sRGB curve at L, zero where the screen clips. denoised: as relative; what a denoiser leaves is another factor, see
    ``tracer.denoising.residual_noise``.

    Raises ValueError for an objective that does not exist.
    """
    scale = 2.0**exposure
    seen: NDArray[np.float64] = np.maximum(np.asarray(luminance, np.float64), 0.0) * scale
    return scale**2 * weights_of_seen(objective, seen)


def weights_of_seen(objective: str, seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weights (any shape) of errors of the exposed picture, from its luminance >= 0."""
    if objective == "absolute":
        return np.ones_like(seen)
    if objective in ("relative", "denoised"):
        return 1.0 / (seen**2 + EPSILON)
    if objective == "display":
        return np.where(seen < 1.0, srgb_slope(seen) ** 2, 0.0)
    raise ValueError(f"unknown objective '{objective}'")


def without_scale(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return weights times the power of two that brings the largest to [1/2, 1): sharing out sees their ratios only.

    Without it the weights of a large exposure, up to 4^64 / EPSILON, would be beyond what float32 holds.
    """
    exponent = int(np.frexp(values.max(initial=0.0))[1])
    return np.ldexp(values, -exponent)


def srgb_slope(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the derivative of the sRGB curve (IEC 61966-2-1) at linear values >= 0."""
    toe = linear <= 0.0031308
    return np.where(toe, 12.92, 1.055 / 2.4 * np.where(toe, 1.0, linear) ** (1.0 / 2.4 - 1.0))
