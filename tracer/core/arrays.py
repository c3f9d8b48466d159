"""Types of NumPy arrays, named after what they hold, and an even choice of pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Integers = NDArray[np.int64]
Counts = NDArray[np.uint32]
Mask = NDArray[np.bool_]


def spread_out(size: int, count: int) -> slice:
    """Return the slice that picks about ``count`` of the ``size`` pixels of a picture, evenly spread.

    Its step is odd, because an even step may pick pixels from a few columns of the picture only.
    """
    return slice(None, None, (size // count) | 1)
