"""Make a picture whose pixels are means of their own samples look as if it had gone through the film's filter."""

from __future__ import annotations

from math import ceil
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

from tracer.core.device import upload

BOX_VARIANCE = 1 / 12
"""Variance of a box filter one pixel wide, in square pixels."""
POSITIONS = 4096
"""Number of positions at which a filter is evaluated."""
MOST_AT_ONCE = 0.5
"""Largest variance, in square pixels, that one blur with three positive taps adds; with more it would invert the finest
detail."""


def refilter(image: NDArray, reconstruction_filter: Any) -> NDArray[np.float32]:
    """Return ``image`` (H, W, C), a mean per pixel, blurred as the ``reconstruction_filter`` of a film would do it.

    A denoiser needs pixels whose noise is their own, so its pictures are those of a box filter. The taps of the blur
    have the variance by which the filter exceeds the box; the filter itself, applied to pixels, would blur twice, with
    three times the error. The edge is repeated. Filters with negative lobes sharpen.
    """
    excess_variance = filter_variance(reconstruction_filter) - BOX_VARIANCE
    blur_count = max(ceil(excess_variance / MOST_AT_ONCE), 1)
    side_tap = 0.5 * excess_variance / blur_count
    result = np.asarray(image, np.float64)
    for axis in (0, 1) * blur_count:
        result = correlate1d(result, [side_tap, 1 - 2 * side_tap, side_tap], axis=axis, mode="nearest")
    return result.astype(np.float32)


def filter_share(reconstruction_filter: Any) -> float:
    """Return the factor by which a filter multiplies the variance of independent pixels: that of a Gaussian like it."""
    return min(1.0, 1.0 / (4.0 * np.pi * filter_variance(reconstruction_filter)))


def untold_share(reconstruction_filter: Any) -> float:
    """Return the part of the variance of a filtered picture that the means of its pixels do not show, 0 to 1.

    The weights of samples vary with their positions in the pixel. The part that the means do show is, per axis, the
    square of the mean weight over the mean square of the weights.
    """
    if reconstruction_filter.is_box_filter():
        return 0.0
    position = (np.arange(POSITIONS) + 0.5) / POSITIONS
    reach = ceil(reconstruction_filter.radius() - 0.5)
    distance = np.arange(-reach, reach + 1)[:, None] + 0.5 - position
    weight = evaluate(reconstruction_filter, distance.ravel()).reshape(distance.shape)
    return float(1.0 - ((weight.mean(axis=1) ** 2).sum() / (weight**2).mean(axis=1).sum()) ** 2)


def filter_variance(reconstruction_filter: Any) -> float:
    """Return the variance of a filter along one axis, in square pixels: its second moment over its integral."""
    if reconstruction_filter.is_box_filter():
        return BOX_VARIANCE
    radius = float(reconstruction_filter.radius())
    x = (np.arange(POSITIONS) + 0.5) / POSITIONS * 2 * radius - radius
    weight = evaluate(reconstruction_filter, x)
    return float((x * x * weight).sum() / weight.sum())


def evaluate(reconstruction_filter: Any, distance: NDArray) -> NDArray[np.float64]:
    """Return the weights of a filter at distances (N,) in pixels, along one axis."""
    return np.asarray(reconstruction_filter.eval(upload(mi.Float, distance)).numpy(), np.float64)
