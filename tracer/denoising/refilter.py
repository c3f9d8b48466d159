"""A picture whose pixels are means of their own samples, made to look as through the film's filter."""

from __future__ import annotations

from math import ceil
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

from tracer.core.device import upload

BOX_VARIANCE = 1 / 12
"""Of a box one pixel wide, in square pixels."""
POSITIONS = 4096
"""At which filters are looked at."""
MOST_AT_ONCE = 0.5
"""Variance that three positive taps can add without doing most to the finest detail."""


def refilter(image: NDArray, reconstruction_filter: Any) -> NDArray[np.float32]:
    """Return ``image`` (H, W, C), of one mean per pixel, blurred as ``reconstruction_filter`` (of a film) would do.

    A denoiser wants pixels whose noise is their own, so its pictures are those of a box filter. The taps have the
    variance that the filter has beyond the box: the filter itself, taken over pixels, would blur twice, with three
    times the error. The edge is repeated. Filters with negative lobes sharpen.
    """
    beyond = filter_variance(reconstruction_filter) - BOX_VARIANCE
    times = max(ceil(beyond / MOST_AT_ONCE), 1)
    side = 0.5 * beyond / times
    result = np.asarray(image, np.float64)
    for axis in (0, 1) * times:
        result = correlate1d(result, [side, 1 - 2 * side, side], axis=axis, mode="nearest")
    return result.astype(np.float32)


def filter_share(reconstruction_filter: Any) -> float:
    """Return by what a filter multiplies the variance of independent pixels: as a Gaussian of its variance does."""
    return min(1.0, 1.0 / (4.0 * np.pi * filter_variance(reconstruction_filter)))


def untold_share(reconstruction_filter: Any) -> float:
    """Return which part of the variance of a filtered picture the means of its pixels do not tell of.

    The weights of samples vary with where in their pixels they are: the square of the mean weight over the mean square,
    per axis, is what the means do tell.
    """
    if reconstruction_filter.is_box_filter():
        return 0.0
    position = (np.arange(POSITIONS) + 0.5) / POSITIONS
    reach = ceil(reconstruction_filter.radius() - 0.5)
    distance = np.arange(-reach, reach + 1)[:, None] + 0.5 - position
    weight = evaluate(reconstruction_filter, distance.ravel()).reshape(distance.shape)
    return float(1.0 - ((weight.mean(axis=1) ** 2).sum() / (weight**2).mean(axis=1).sum()) ** 2)


def filter_variance(reconstruction_filter: Any) -> float:
    """Return the second moment over the integral of a filter, in square pixels, along one axis."""
    if reconstruction_filter.is_box_filter():
        return BOX_VARIANCE
    radius = float(reconstruction_filter.radius())
    x = (np.arange(POSITIONS) + 0.5) / POSITIONS * 2 * radius - radius
    weight = evaluate(reconstruction_filter, x)
    return float((x * x * weight).sum() / weight.sum())


def evaluate(reconstruction_filter: Any, distance: NDArray) -> NDArray[np.float64]:
    """Return the weights of a filter at distances (N,) in pixels, along one axis."""
    return np.asarray(reconstruction_filter.eval(upload(mi.Float, distance)).numpy(), np.float64)
