"""What a caller is told while a picture is rendered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tracer.adaptive.convergence import Noise
from tracer.adaptive.stopping import LEAST_SPP, Clock
from tracer.core.quantities import percent, with_prefix

MOST_UNFINISHED = 0.99
"""Largest fraction that is shown of a render that may still go on, or whose picture is still to be made."""


@dataclass(frozen=True)
class Progress:
    """What a progress callback is told after every pass, and once more at the end with the picture of the result.

    Example::

        import tracer


        def watch(now: tracer.Progress) -> bool:
            print(f"{100 * now.fraction:.0f} %: {now.in_words()}")
            return now.seconds < 60  # False stops, and keeps the picture so far


        tracer.render("scene.xml", spp=256, progress=watch)
    """

    done: int
    """Samples drawn so far."""
    total: int
    """Samples that are expected in all. It may rise and fall if ``is_open``; a bar should show ``fraction``."""
    seconds: float
    """Seconds since the start."""
    remaining: float | None = None
    """Seconds that are expected to be left; None before the first pass has been timed."""
    noise: float | None = None
    """Error that ``noise_share`` of the pixels are estimated to keep within; None without a noise target."""
    converged: float | None = None
    """Share of the pixels that are estimated to be within the noise target; None without one."""
    fraction: float = 0.0
    """Part of the way to the end, 0 to 1, see ``Course``. It never falls; it is 1 if the render is complete."""
    is_open: bool = False
    """Whether a noise target or a limit of time may end the render, so that ``total`` is an estimate."""
    finished: bool = False
    """Whether the render has ended, complete or not; what the callback returns then does not matter."""
    develop: Callable[[], NDArray[np.float32]] = field(default=lambda: np.zeros((0, 0, 3), np.float32), repr=False)
    """Function that makes the present picture (H, W, C), linear, in the channels of the result. It is made when this is
    called, and the render waits for it: the more pixels, the longer."""
    count: Callable[[], NDArray[np.uint32]] = field(default=lambda: np.zeros((0, 0), np.uint32), repr=False)
    """Function that counts the present samples of each pixel (H, W)."""

    @property
    def image(self) -> NDArray[np.float32]:
        """The present picture (H, W, C), see ``develop``."""
        return self.develop()

    @property
    def samples(self) -> NDArray[np.uint32]:
        """The present samples of each pixel (H, W), see ``count``."""
        return self.count()

    def in_words(self) -> str:
        """Return in words the samples drawn, their total if it is certain, and the converged share if it is known."""
        text = with_prefix(self.done)
        if not self.is_open:
            text += f" of {with_prefix(self.total)}"
        text += " samples"
        return text if self.converged is None else f"{text}, {percent(self.converged, 0)} % converged"


ProgressCallback = Callable[[Progress], bool | None]
"""Function that is called after every pass and at the end; it returns False to stop with the picture as it is."""


class Course:
    """How far a render is on its way to whatever ends it first: its budget of samples, its noise target or its time.

    The fractions for budget and time are the part that is spent. The fraction for a noise target is the number of
    samples at which the noise was last measured over the number that it then asked for; until it is measured again, at
    the end of the round, new samples add at most half of what was left. As a new measurement may ask for more samples
    than the last one, the fraction returned is the largest so far: a bar stands still rather than go back.
    """

    def __init__(self, clock: Clock, total: int, pixel_count: int) -> None:
        """``total``: the most samples that are drawn, of all ``pixel_count`` pixels together."""
        self.clock, self.total = clock, total
        self.least = min(LEAST_SPP * pixel_count, total)
        self.needed = self.measured_at = 0
        self.largest = 0.0

    def measured(self, noise: Noise, done: int) -> None:
        """Note the noise that was measured after ``done`` samples."""
        self.measured_at = done
        self.needed = round(min(max(done * noise.needed, self.least), self.total))

    def expected(self, done: int, goal: int) -> int:
        """Return the samples that are expected in all; ``goal``: their number at the end of the round under way."""
        return min(max(self.needed, goal, done), self.total) if self.needed else self.total

    def fraction(self, done: int, goal: int) -> float:
        """Return the fraction of the way to the end after ``done`` samples, at most MOST_UNFINISHED; it never falls."""
        by_samples = done / self.expected(done, goal)
        if self.needed:
            by_samples = min(by_samples, 0.5 * (1.0 + self.measured_at / self.needed))
        present = max(by_samples, done / self.total, self.clock.share_over())
        self.largest = max(self.largest, min(present, MOST_UNFINISHED))
        return self.largest

    def seconds_left(self, done: int, goal: int) -> float | None:
        """Return the seconds that are expected to be left; None before the first pass has been timed."""
        by_samples = self.clock.seconds_for(self.expected(done, goal) - done)
        return None if by_samples is None else min(by_samples, self.clock.seconds_left())


StepCallback = Callable[[str, int, int], bool | None]
"""Function that is called with the name of the step under way, how much of it is done, and how much there is in all. It
returns False to stop."""

CountCallback = Callable[[int, int], bool | None]
"""Function that is called with how much is done and how much there is in all. It returns False to stop."""
