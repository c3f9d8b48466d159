"""Which error is to be small: the weight w of each pixel's variance in the sum that an allocation minimises."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

Objective = Literal["absolute", "relative", "display", "denoised"]
OBJECTIVES: tuple[str, ...] = get_args(Objective)
EPSILON = 0.01
"""Added to the squared luminance in relative errors, so that black pixels do not take everything."""


def weights(objective: str, luminance: ArrayLike, exposure: float = 0.0) -> NDArray[np.float64]:
    """Return w >= 0 for pixels of mean ``luminance`` L (any shape), seen at ``exposure`` in stops: L 2^exposure.

    absolute: 1. relative: 1 / (L^2 + EPSILON). display: the squared slope of the sRGB curve at L, zero where the
    screen clips. denoised: as relative; what a denoiser leaves is another factor, see ``tracer.leftover``.
    """
    seen: NDArray[np.float64] = np.maximum(np.asarray(luminance, np.float64), 0.0) * 2.0**exposure
    if objective == "absolute":
        return np.ones_like(seen)
    if objective in ("relative", "denoised"):
        return 1.0 / (seen**2 + EPSILON)
    if objective == "display":
        return np.where(seen < 1.0, srgb_slope(seen) ** 2, 0.0)
    raise ValueError(f"unknown objective '{objective}'")


def srgb_slope(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the derivative of the sRGB curve (IEC 61966-2-1) at linear values >= 0."""
    toe = linear <= 0.0031308
    return np.where(toe, 12.92, 1.055 / 2.4 * np.where(toe, 1.0, linear) ** (1.0 / 2.4 - 1.0))
