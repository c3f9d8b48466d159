"""Small filters of pictures with NumPy alone: for three or five pixels it is several times as fast as SciPy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tracer.core.arrays import Singles

Extremum = Callable[..., Singles]
"""``np.maximum`` or ``np.minimum``."""


def blurred(picture: Singles, side_tap: float, repeats: int = 1) -> Singles:
    """Return a picture (H, W, ...) after blurs with taps ``side_tap``, 1 - 2 ``side_tap``, ``side_tap`` on both axes.

    The edge is repeated.
    """
    side, middle = np.float32(side_tap), np.float32(1.0 - 2.0 * side_tap)
    for axis in (0, 1) * repeats:
        before, after = neighbours(picture, axis)
        picture = middle * picture + side * (before + after)
    return picture


def extreme(picture: Singles, side: int, of: Extremum) -> Singles:
    """Return the extremum (H, W) of the pixels within squares of an odd ``side`` around each pixel (H, W)."""
    for axis in (0, 1) * (side // 2):
        before, after = neighbours(picture, axis)
        picture = of(of(before, after), picture)
    return picture


def neighbours(picture: Singles, axis: int) -> tuple[Singles, Singles]:
    """Return the pixels before and after each pixel of a picture (H, W, ...); the edge is repeated."""
    first, last = [slice(None)] * picture.ndim, [slice(None)] * picture.ndim
    first[axis], last[axis] = slice(0, 1), slice(-1, None)
    padded = np.concatenate([picture[tuple(first)], picture, picture[tuple(last)]], axis=axis)
    first[axis], last[axis] = slice(0, -2), slice(2, None)
    return padded[tuple(first)], padded[tuple(last)]


def local_variance(picture: Singles) -> Singles:
    """Return the variance (H, W) of each pixel and its eight neighbours; the edge is repeated.

    Sums are of differences from the pixel, so that what is far brighter elsewhere is no matter.
    """
    height, width = picture.shape
    padded = np.pad(picture, 1, mode="edge")
    total, squares = np.zeros_like(picture), np.zeros_like(picture)
    for down in range(3):
        for right in range(3):
            difference = padded[down : down + height, right : right + width] - picture
            total += difference
            squares += np.square(difference)
    variance = np.maximum(squares - np.square(total) / np.float32(9), np.float32(0)) / np.float32(9)
    return np.asarray(variance, np.float32)
