"""Types of NumPy arrays, named after what they hold, and an even choice of pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
"""Array of numbers in double precision."""
Singles = NDArray[np.float32]
"""Array of numbers in single precision, such as a picture."""
Integers = NDArray[np.int64]
"""Array of whole numbers, such as indices."""
Counts = NDArray[np.uint32]
"""Array of counts, such as samples per pixel."""
Indices = NDArray[np.uint32]
"""Array of indices in 32 bits, as the device has them."""
Mask = NDArray[np.bool_]
"""Array that tells which entries are chosen."""


def spread_out(size: int, count: int) -> slice:
    """Return the slice that picks about ``count`` of the ``size`` pixels of a picture, evenly spread.

    Its step is odd, because an even step may pick pixels from a few columns of the picture only.
    """
    return slice(None, None, (size // count) | 1)


def evenly_chosen(size: int, most: int) -> Integers:
    """Return at most ``most`` of the numbers below ``size`` >= 1, evenly spread, the first and the last among them."""
    return np.unique(np.linspace(0, size - 1, min(size, most)).round().astype(np.int64))
