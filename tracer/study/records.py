"""What a study knows of a scene, of a cell, and of a method: records without behaviour.

``tracer.study.run.run_study`` has an example.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from tracer.image.metrics import Scores
from tracer.study.cells import Cell, RenderCost
from tracer.study.gains import Gain, Interval

CLOSE = 0.1
"""Largest error (RMS) of a reference, relative to that of a cell, for which the cell is not "too close" to it."""


@dataclass(frozen=True)
class SceneFacts:
    """What is known of a scene and of its reference."""

    name: str
    width: int
    height: int
    reference_spp: int
    """Samples per pixel of both halves of the reference."""
    reference_mse: float
    """Mean squared error of the reference, from the difference of its halves."""
    reference_relative_mse: float
    """The same, relative as in ``metrics.relative_mse``."""
    halves_agree: bool
    """Whether the two halves of the reference show the same picture."""
    disagreement: float
    """p-value of the test that the halves show the same picture."""
    limit: float
    """Most that an allocation could gain in relMSE at equal samples if samples were independent, 1 + CV^2."""


@dataclass(frozen=True)
class Measurement:
    """A cell, what its picture took, and its scores."""

    cell: Cell
    took: RenderCost
    scores: Scores
    too_close: bool
    """Whether the error of the reference is more than the part CLOSE of the cell's, both in relMSE (RMS)."""
    own: dict[str, float] = field(default_factory=dict)
    """Values of a person's own metrics, by name; the error of the reference is not subtracted from them."""


@dataclass(frozen=True)
class Failure:
    """A cell that could not be rendered, and why."""

    scene: str
    method: str
    budget: str
    seed: int
    message: str


@dataclass(frozen=True)
class Gains:
    """Gains of a method on a scene at one budget."""

    scene: str
    samples: Gain
    """Gain at equal samples."""
    time: Gain
    """Gain at equal time."""
    trimmed: Gain
    """Gain in the trimmed relMSE, at equal samples."""
    trimmed_time: Gain
    """Gain in the trimmed relMSE, at equal time."""


GAINS = ("samples", "time", "trimmed", "trimmed_time")
"""Names of the gains, which are fields of ``Gains``."""


@dataclass(frozen=True)
class Limits:
    """What an oracle gains on a scene at one budget."""

    samples: float | None
    """Gain at equal samples; None if it is not known."""
    time: float | None
    """Gain at equal time; None if it was not measured."""


@dataclass(frozen=True)
class Row:
    """A method on a scene at one budget: means over seeds, and gains over the baseline."""

    scene: str
    budget: str
    method: str
    seeds: int
    spp: float
    """Samples taken per pixel of the picture, with those that a sampler rounds up to and those of the film's border."""
    samples: float
    """Samples taken for a picture, mean over seeds."""
    seconds: float
    """Seconds that a picture took, geometric mean over seeds."""
    drawing: float
    """Share of the seconds in which radiance samples were drawn."""
    scores: Scores
    gain_samples: Interval | None
    """Error of the baseline over that of the method at equal samples: the error that the method's objective minimises.
    None where the baseline failed."""
    gain_time: Interval | None
    """The same at equal time."""
    gain_trimmed: Interval | None
    """The same as gain_samples, but in the trimmed relMSE."""
    gain_trimmed_time: Interval | None
    """The same as gain_time, but in the trimmed relMSE."""
    oracle_share: float | None
    """log(gain_samples) / log(limit), over a uniform baseline; None where there is next to nothing to gain. The limit
    is the gain of the study's oracle by samples for the method's objective. Without such an oracle it is the limit of
    the scene for methods that minimise the relative error, and the share of all other methods is None."""
    oracle_time_share: float | None
    """The same at equal time; None if the study has no oracle by time."""
    paired: bool
    """Whether all times were measured next to the baseline's, in the same run."""
    too_close: bool
    """Whether any of the cells is too close to the reference, see ``Measurement``."""
    own: dict[str, float] = field(default_factory=dict)
    """Means of a person's own metrics, by name."""


@dataclass(frozen=True)
class Mean:
    """Gains of a method at one budget, geometric mean over scenes."""

    budget: str
    method: str
    scenes: int
    """Number of scenes on which both the method and the baseline were measured."""
    gain_samples: Interval
    gain_time: Interval
    gain_trimmed: Interval
    gain_trimmed_time: Interval
    worst: float
    """Least gain_samples of any scene."""
    worst_scene: str
    """Name of that scene."""
    worst_time: float
    """Least gain_time of any scene."""
    oracle_share: float | None
    """log(gain_samples) over log(limit), both means over the scenes where there is something to gain; else None."""
    oracle_time_share: float | None
    """The same at equal time."""


SCORES = tuple(Scores.__dataclass_fields__)
"""Names of the scores, which are fields of ``Scores``."""
