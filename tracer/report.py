"""What is known of a render: what was decided and why, its rounds, and how long it took."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tracer.adaptive.convergence import Noise
from tracer.adaptive.stopping import Reason
from tracer.core import parallel
from tracer.core.quantities import samples_in_words
from tracer.scene.frame import Frame
from tracer.settings import Settings

if TYPE_CHECKING:
    from tracer.film.estimate import Statistics


@dataclass(frozen=True)
class Round:
    """One round: its samples and the time it took. ``tracer.Report`` has an example."""

    samples: int
    """Samples of the round, of all pixels together."""
    least: int
    """Fewest samples that any pixel has after the round."""
    most: int
    """Most samples that any pixel has after the round."""
    seconds: float
    """Seconds that the round took."""


ENDED_BY: dict[Reason, str] = {
    "spp": "its budget of samples",
    "noise": "its noise target",
    "time": "its limit of time",
    "person": "a person",
}
"""What ended a render, in words."""


@dataclass
class Report:
    """What was decided in a render and why, and how long it took. Seconds are wall-clock seconds.

    Example::

        import tracer

        report = tracer.render("scene.xml", noise=0.05).report
        print(report)  # samples, rounds, what ended the render, and notes
        [drawn.samples for drawn in report.rounds]
        report.converged  # share of the pixels that are estimated to be within 5 %
        report.histogram  # {"8-15": 1200, ...}: pixels by their number of samples
    """

    settings: Settings
    """The settings of the render, with their defaults."""
    rounds: list[Round] = field(default_factory=list)
    """Every round that was drawn, in order."""
    notes: list[str] = field(default_factory=list)
    """Sentences for a person about fallbacks, samples that were not finite, or an interruption."""
    unwritten: list[str] = field(default_factory=list)
    """Sentences about files that could not be written while the render went on, such as its checkpoint."""
    stopped_by: Reason | None = None
    """What ended the render: its budget (spp), the noise target, the time, or a person. None while it is under way."""
    spp: float = 0.0
    """Mean samples per pixel that were drawn, including those that only decided or were not finite. The number that was
    asked for is in ``settings``."""
    noise: float | None = None
    """Error that ``noise_share`` of the pixels are estimated to keep within; None without a noise target."""
    converged: float | None = None
    """Share of the pixels that are estimated to be within the noise target; None without one."""
    light_given_back: float = 0.0
    """Part of the picture's mean that decisions had lost and that was given back, see ``tracer.film.bias``."""
    pixels_at_most: int = 0
    """Number of pixels that have as many samples as a pixel may have."""
    histogram: dict[str, int] = field(default_factory=dict)
    """Number of pixels by range of samples, between powers of two: "8-15" and so on."""
    seconds_drawing: float = 0.0
    """Seconds of drawing the samples of the picture; all others are overhead."""
    seconds_pilot: float = 0.0
    """Seconds of tracing pilot rays."""
    seconds_guiding: float = 0.0
    """Seconds of learning which lights matter where."""
    seconds_deciding: float = 0.0
    """Seconds of computing importance and allocation."""
    seconds_adding: float = 0.0
    """Seconds of adding samples to the sums of their pixels."""
    seconds_statistics: float = 0.0
    """Seconds of computing, before each decision, what is known of the pixels."""
    seconds_developing: float = 0.0
    """Seconds of making the picture from the sums, at the end and wherever its noise is measured."""
    elsewhere: dict[str, Any] = field(default_factory=dict)
    """For a render on workers: how many there were at the end, units, and bytes that travelled. Else empty."""
    seconds_features: float = 0.0
    """Seconds of drawing the features that were asked for or that a checkpoint keeps."""
    seconds_denoising: float = 0.0
    """Seconds of denoising, and of drawing the features for it if no checkpoint keeps them."""

    def __str__(self) -> str:
        """Return what a person wants to know: samples, rounds, what ended the render, and the notes."""
        rounds = [
            f"{drawn.least}" if drawn.least == drawn.most else f"{drawn.least} to {drawn.most}" for drawn in self.rounds
        ]
        text = f"{samples_in_words(self.spp)} in {len(rounds)} round{'' if len(rounds) == 1 else 's'}"
        if rounds:
            text += f", after which pixels had {', then '.join(rounds)}"
        if self.stopped_by is not None:
            text += f"; ended by {ENDED_BY[self.stopped_by]}"
        return "\n".join([f"{text}.", *self.notes])

    @property
    def complete(self) -> bool:
        """Whether the render went on until its budget was spent, its noise target was met or its time was over."""
        return self.stopped_by != "person"

    def note(self, text: str, once: str = "") -> None:
        """Add a note, unless it is there already, as after a resume, or a note that begins with ``once`` is."""
        if text not in self.notes and (not once or not any(note.startswith(once) for note in self.notes)):
            self.notes.append(text)

    def describe(self, frame: Frame, statistics: Statistics, done: int, noise: Noise | None) -> None:
        """Fill in what is known of the pixels at the end; ``done``: samples that were drawn, of all pixels together."""
        count, invalid = (values[frame.inner] for values in (statistics.count, statistics.invalid))
        lost = int(statistics.invalid.sum())
        if lost:
            self.note(
                f"{lost} samples in {np.count_nonzero(statistics.invalid)} pixels were not finite and are left out"
                f"{empty_pixels((count == 0) & (invalid > 0))}."
            )
        self.spp = done / frame.pixel_count
        if not self.complete:
            asked_for = f"at most {self.settings.spp}" if self.settings.is_open else self.settings.spp
            self.note(f"Stopped after {samples_in_words(self.spp)}, of {asked_for}.")
        self.pixels_at_most = int(np.count_nonzero(count + invalid >= self.settings.most_samples))
        self.histogram = histogram(count)
        if noise is not None and self.settings.noise is not None:
            self.noise, self.converged = noise.error, noise.converged

    def as_dict(self) -> dict[str, Any]:
        """Return the report as plain numbers, strings, lists and dictionaries, for JSON."""
        plain = {name: getattr(self, name) for name in vars(self) if name not in ("settings", "rounds")}
        rounds = [vars(round_of_samples) for round_of_samples in self.rounds]
        return {"settings": self.settings.model_dump(), "rounds": rounds, "complete": self.complete, **plain}


def histogram(count: NDArray[np.uint32]) -> dict[str, int]:
    """Return how many counts lie between powers of two, by "first-last"; empty ranges at both ends are left out."""
    exponents = parallel.fill(np.empty(count.shape, np.int8), exponent_of, count)
    numbers = {}
    for exponent in range(int(exponents.min()), int(exponents.max()) + 1):
        first, last = (1 << exponent) // 2, max((1 << exponent) - 1, 0)
        numbers[str(first) if first == last else f"{first}-{last}"] = int(np.count_nonzero(exponents == exponent))
    return numbers


def exponent_of(count: NDArray[np.uint32]) -> NDArray[np.int32]:
    """Return e of count = m 2^e with m in [0.5, 1)."""
    exponent: NDArray[np.int32] = np.frexp(count.astype(np.float64))[1]
    return exponent


NAMED = 8
"""Most pixels that a note lists by their coordinates."""


def empty_pixels(empty: NDArray[np.bool_]) -> str:
    """Return a clause that names the pixels without a finite sample, which ``empty`` (H, W) marks; "" if none is."""
    rows, columns = np.nonzero(empty)
    if len(rows) == 0:
        return ""
    places = [f"({x}, {y})" for x, y in zip(columns[:NAMED], rows[:NAMED], strict=True)]
    more = f" and {len(rows) - NAMED} more" if len(rows) > NAMED else ""
    return (
        f"; pixels (x, y) without any other show what the filter brings from their neighbours, or black: "
        f"{', '.join(places)}{more}"
    )
