"""What a caller is told while a picture is being made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Progress:
    """What a progress callback is told after every pass."""

    done: int
    """Samples drawn."""
    total: int
    """Samples that are expected in all: the budget, or fewer if a noise target is expected to be met before."""
    seconds: float
    """Since the start."""
    remaining: float | None = None
    """Seconds that are expected to be left; None before a first pass has been timed."""
    noise: float | None = None
    """Error that ``noise_share`` of the pixels are estimated to keep within; None without a noise target."""
    converged: float | None = None
    """Share of the pixels that are estimated to be within the noise target; None without one."""
    develop: Callable[[], NDArray[np.float32]] = field(default=lambda: np.zeros((0, 0, 3), np.float32), repr=False)
    """Makes the picture as it is now (H, W, C), in the channels of the result; takes milliseconds to seconds."""
    count: Callable[[], NDArray[np.uint32]] = field(default=lambda: np.zeros((0, 0), np.uint32), repr=False)
    """Counts the samples of each pixel (H, W) as it is now."""

    @property
    def image(self) -> NDArray[np.float32]:
        """The picture as it is now, see ``develop``."""
        return self.develop()

    @property
    def samples(self) -> NDArray[np.uint32]:
        """The samples of each pixel, see ``count``."""
        return self.count()


ProgressCallback = Callable[[Progress], bool | None]
"""Called after every pass; return False to stop with what there is."""
