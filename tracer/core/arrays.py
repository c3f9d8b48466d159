"""Types of arrays in NumPy, by what they hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Integers = NDArray[np.int64]
Counts = NDArray[np.uint32]
Mask = NDArray[np.bool_]
