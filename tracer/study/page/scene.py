"""The pictures of a scene that a page shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Shown:
    """A picture by a method."""

    method: str
    image: NDArray[np.float32]
    """(H, W, 3), linear sRGB."""
    counts: NDArray[np.float32]
    """(H, W): samples per pixel."""
    relative_mse: float
    """Score of the picture."""


@dataclass(frozen=True)
class ScenePictures:
    """Pictures by all methods at one budget and seed."""

    name: str
    budget: str
    seed: int
    reference: NDArray[np.float64]
    """(H, W, 3), linear sRGB."""
    shown: list[Shown]
    """Pictures by all methods, the baseline first."""
