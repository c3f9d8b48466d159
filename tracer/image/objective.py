"""Which error is to be minimised: the weight w of each pixel's variance in the sum that an allocation minimises."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

Objective = Literal["absolute", "relative", "display"]
"""Name of the error that is minimised, see ``weights``."""
OBJECTIVES: tuple[str, ...] = get_args(Objective)
"""Names of all objectives."""
EPSILON = 0.01
"""Added to the squared luminance of the exposed picture in relative errors, so that black pixels do not count for
everything."""


def weights(objective: str, luminance: ArrayLike, exposure: float = 0.0) -> NDArray[np.float64]:
    """Return w >= 0 for pixels of mean ``luminance`` (any shape): the squared error that is seen over the radiance's.

    Every objective judges the exposed picture, s = 2^exposure times the radiance, with ``exposure`` in stops. So a
    scene with half the light has the same errors at one stop more. With the exposed luminance L = s luminance, w is s^2
    times

    absolute: 1, the error of the exposed radiance. relative: 1 / (L^2 + EPSILON). display: the squared slope of the
    sRGB curve at L, zero where the screen clips.

    Raises ValueError for an objective that does not exist.
    """
    scale = 2.0**exposure
    seen: NDArray[np.float64] = np.maximum(np.asarray(luminance, np.float64), 0.0) * scale
    return scale**2 * weights_of_seen(objective, seen)


def weights_of_seen(objective: str, seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weights (any shape) of squared errors of the exposed picture, from its luminance ``seen`` >= 0."""
    if objective == "absolute":
        return np.ones_like(seen)
    if objective == "relative":
        return 1.0 / (seen**2 + EPSILON)
    if objective == "display":
        return np.where(seen < 1.0, srgb_slope(seen) ** 2, 0.0)
    raise ValueError(f"unknown objective '{objective}'")


def without_scale(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return weights times the power of two that brings the largest to [1/2, 1): for an allocation only ratios count.

    Unscaled, the weights of a large exposure, up to 4^64 / EPSILON, would exceed what float32 can hold.
    """
    exponent = int(np.frexp(values.max(initial=0.0))[1])
    return np.ldexp(values, -exponent)


def srgb_slope(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the derivative of the sRGB curve (IEC 61966-2-1) at linear values >= 0."""
    toe = linear <= 0.0031308
    return np.where(toe, 12.92, 1.055 / 2.4 * np.where(toe, 1.0, linear) ** (1.0 / 2.4 - 1.0))
