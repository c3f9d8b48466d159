"""Make a picture whose pixels are means of their own samples look as if it had gone through the film's filter."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import ceil
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

from tracer.core.arrays import Singles
from tracer.core.device import upload
from tracer.denoising.neighbours import blurred

BOX_VARIANCE = 1 / 12
"""Variance of a box filter one pixel wide, in square pixels."""
POSITIONS = 4096
"""Number of positions at which a filter is evaluated."""
WIDEST = 1e4
"""Largest variance of a filter, in square pixels."""
MOST_AT_ONCE = 0.5
"""Largest variance, in square pixels, that one blur with three positive taps adds; with more it would invert the finest
detail."""


@dataclass(frozen=True)
class FilterShape:
    """What of a film's reconstruction filter matters when its picture is denoised, along one axis."""

    variance: float
    """Its variance in square pixels: second moment over integral."""
    squared_weights: tuple[float, ...]
    """Mean squared weight that a sample has in the pixels before, at and after its own, over the squared sum of the
    mean weights: what is left of the variance of independent pixels."""
    hidden_share: float
    """The part of the variance of a filtered picture that the means of its pixels do not show, 0 to 1: the weights of
    samples vary with their positions in the pixel. Unlike the others it is that of both axes together."""

    @property
    def reach(self) -> int:
        """Pixels on each side that ``refilter`` or ``filtered_variance`` looks at."""
        return max(self.blurs, len(self.squared_weights) // 2)

    @property
    def blurs(self) -> int:
        """Number of blurs with three taps that make up for the filter."""
        return max(ceil((self.variance - BOX_VARIANCE) / MOST_AT_ONCE), 1)

    @classmethod
    def of(cls, reconstruction_filter: Any) -> FilterShape:
        """Return the shape of an ``mi.ReconstructionFilter``."""
        if reconstruction_filter.is_box_filter():
            return cls(BOX_VARIANCE, (1.0,), 0.0)
        radius = float(reconstruction_filter.radius())
        x = (np.arange(POSITIONS) + 0.5) / POSITIONS * 2 * radius - radius
        weight = evaluate(reconstruction_filter, x)
        variance = float((x * x * weight).sum() / weight.sum())
        position = (np.arange(POSITIONS) + 0.5) / POSITIONS
        reach = ceil(radius - 0.5)
        distance = np.arange(-reach, reach + 1)[:, None] + 0.5 - position
        weight = evaluate(reconstruction_filter, distance.ravel()).reshape(distance.shape)
        mean, mean_square = weight.mean(axis=1), (weight**2).mean(axis=1)
        # The part that the means do show is the squared mean weight over the mean squared weight.
        hidden_share = float(1.0 - ((mean**2).sum() / mean_square.sum()) ** 2)
        return cls(variance, tuple((mean_square / mean.sum() ** 2).tolist()), hidden_share)

    @classmethod
    def from_plain(cls, plain: dict[str, Any]) -> FilterShape:
        """Return a shape from what ``plain`` returned. Raises KeyError, TypeError or ValueError for anything else."""
        weights = tuple(float(weight) for weight in plain["squared_weights"])
        shape = cls(float(plain["variance"]), weights, float(plain["hidden_share"]))
        numbers = np.array([shape.variance, shape.hidden_share, *weights])
        if len(weights) % 2 != 1 or not np.all(abs(numbers) < WIDEST) or not 0.0 <= shape.hidden_share <= 1.0:
            raise ValueError("no shape of a filter")
        return shape

    def plain(self) -> dict[str, Any]:
        """Return numbers and lists, for JSON."""
        return {**asdict(self), "squared_weights": list(self.squared_weights)}


def refilter(image: NDArray, shape: FilterShape) -> Singles:
    """Return ``image`` (H, W, C), a mean per pixel, blurred as a filter of this ``shape`` would do it.

    A denoiser needs pixels whose noise is their own, so its pictures are those of a box filter. The taps of the blur
    have the variance by which the filter exceeds the box; the filter itself, applied to pixels, would blur twice, with
    three times the error. The edge is repeated. Filters with negative lobes sharpen.
    """
    excess_variance = shape.variance - BOX_VARIANCE
    result: Singles = np.asarray(image, np.float32)
    if excess_variance == 0.0:
        return result
    return blurred(result, 0.5 * excess_variance / shape.blurs, shape.blurs)


def filtered_variance(variance: NDArray, shape: FilterShape) -> Singles:
    """Return the variance (H, W) of a filtered picture whose pixels' own means have the ``variance`` (H, W)."""
    result: Singles = np.asarray(variance, np.float32)
    if len(shape.squared_weights) > 1:
        for axis in (0, 1):
            result = correlate1d(result, shape.squared_weights, axis=axis, mode="nearest")
    return result


def evaluate(reconstruction_filter: Any, distance: NDArray) -> NDArray[np.float64]:
    """Return the weights of a filter at distances (N,) in pixels, along one axis."""
    return np.asarray(reconstruction_filter.eval(upload(mi.Float, distance)).numpy(), np.float64)
