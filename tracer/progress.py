"""What a caller is told while a picture is being made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tracer.adaptive.convergence import Noise
from tracer.adaptive.stopping import LEAST_SPP, Clock
from tracer.core.quantities import percent, with_prefix

MOST_UNFINISHED = 0.99
"""Of a render, as long as it may go on, and while what its samples have become is still to be made."""


@dataclass(frozen=True)
class Progress:
    """What a progress callback is told after every pass, and once more at the end, with the picture of the result."""

    done: int
    """Samples drawn."""
    total: int
    """Samples that are expected in all. It may rise and fall where ``is_open``; for a bar there is ``fraction``."""
    seconds: float
    """Since the start."""
    remaining: float | None = None
    """Seconds that are expected to be left; None before a first pass has been timed."""
    noise: float | None = None
    """Error that ``noise_share`` of the pixels are estimated to keep within; None without a noise target."""
    converged: float | None = None
    """Share of the pixels that are estimated to be within the noise target; None without one."""
    fraction: float = 0.0
    """Part of the way to the end, 0 to 1, see ``Course``: never less than was told before; 1 if it is complete."""
    is_open: bool = False
    """Whether a noise target or a limit of time may end the render, so that ``total`` is an estimate."""
    finished: bool = False
    """Whether this is told at the end, complete or not; what the callback returns is then of no matter."""
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

    def in_words(self) -> str:
        """Return the samples, of how many if that is certain, and how many pixels have converged."""
        text = with_prefix(self.done)
        if not self.is_open:
            text += f" of {with_prefix(self.total)}"
        text += " samples"
        return text if self.converged is None else f"{text}, {percent(self.converged, 0)} % converged"


ProgressCallback = Callable[[Progress], bool | None]
"""Called after every pass, and at the end; return False to stop with what there is."""


class Course:
    """How far a render is on its way to whatever ends it first: its samples, its noise target or its time.

    Samples and time are fractions of what there is to spend. For a noise target it is the samples at which the noise
    was last measured over those that were then found to be needed; until it is measured again, at the end of the
    round, samples count for at most half of what was left. As a new measure may ask for more than the last one did,
    the fraction is the largest so far: a bar stands still and does not go back.
    """

    def __init__(self, clock: Clock, total: int, pixel_count: int) -> None:
        """``total``: the most samples that are drawn of all ``pixel_count`` pixels."""
        self.clock, self.total = clock, total
        self.least = min(LEAST_SPP * pixel_count, total)
        self.needed = self.measured_at = 0
        self.largest = 0.0

    def measured(self, noise: Noise, done: int) -> None:
        """Take in the noise after ``done`` samples."""
        self.measured_at = done
        self.needed = round(min(max(done * noise.needed, self.least), self.total))

    def expected(self, done: int, goal: int) -> int:
        """Return the samples that are expected in all; the round under way ends with ``goal`` of them."""
        return min(max(self.needed, goal, done), self.total) if self.needed else self.total

    def fraction(self, done: int, goal: int) -> float:
        """Return the part of the way to the end that is behind, at most MOST_UNFINISHED, never less than before."""
        by_samples = done / self.expected(done, goal)
        if self.needed:
            by_samples = min(by_samples, 0.5 * (1.0 + self.measured_at / self.needed))
        now = max(by_samples, done / self.total, self.clock.share_over())
        self.largest = max(self.largest, min(now, MOST_UNFINISHED))
        return self.largest

    def seconds_left(self, done: int, goal: int) -> float | None:
        """Return the seconds that are expected to be left; None before a first pass has been timed."""
        by_samples = self.clock.seconds_for(self.expected(done, goal) - done)
        return None if by_samples is None else min(by_samples, self.clock.seconds_left())


StepCallback = Callable[[str, int, int], bool | None]
"""Called with what is under way, how much of it is done, and how much there is. Return False to stop."""

CountCallback = Callable[[int, int], bool | None]
"""Called with how much is done, and how much there is. Return False to stop."""
