"""What a study knows of a scene, of a cell, and of a method: records without behaviour."""

from __future__ import annotations

from dataclasses import dataclass

from tracer.image.metrics import Scores
from tracer.study.cells import Cell, Took
from tracer.study.gains import Gain, Interval

CLOSE = 0.1
"""A reference whose own error (RMS) is more than this part of a cell's is too close to it."""


@dataclass(frozen=True)
class SceneFacts:
    """What is known of a scene."""

    name: str
    width: int
    height: int
    reference_spp: int
    """Samples per pixel of both halves of the reference."""
    reference_mse: float
    """Mean squared error of the reference, from the difference of its halves."""
    reference_relative_mse: float
    halves_agree: bool
    disagreement: float
    """p-value of the test that the halves show the same picture."""
    limit: float
    """What the oracle could gain in relMSE at equal samples, 1 + CV^2."""


@dataclass(frozen=True)
class Measurement:
    """One cell measured."""

    cell: Cell
    took: Took
    scores: Scores
    too_close: bool
    """Whether the reference is too close for its relMSE."""


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
    """At equal samples."""
    time: Gain
    """At equal time."""
    trimmed: Gain
    """Of the trimmed error, at equal samples."""


GAINS = ("samples", "time", "trimmed")


@dataclass(frozen=True)
class Limits:
    """What an oracle gains on a scene at one budget."""

    samples: float | None
    """At equal samples, if it is known."""
    time: float | None
    """At equal time, if it was measured."""


@dataclass(frozen=True)
class Row:
    """One method on one scene at one budget: means over seeds, and gains over the baseline."""

    scene: str
    budget: str
    method: str
    seeds: int
    spp: float
    """Samples taken over pixels of the picture: what a sampler rounds up to, and a film's border, count."""
    samples: float
    seconds: float
    """Of one picture, geometric mean."""
    drawing: float
    """Share of the seconds in which radiance samples were drawn."""
    scores: Scores
    gain_samples: Interval | None
    """Error of the baseline over that of the method, per sample: relMSE, or what the method's objective is after; None
    where the baseline failed."""
    gain_time: Interval | None
    """The same per second."""
    gain_trimmed: Interval | None
    """As gain_samples, of the trimmed relMSE."""
    oracle_share: float | None
    """log(gain_samples) / log(limit), over a uniform baseline; None where there is next to nothing to gain. The limit
    is what the study's oracle by samples gained that has the method's objective; if there is none, that of the scene
    for methods that minimise the relative error, and None for others."""
    oracle_time_share: float | None
    """The same at equal time; None if the study has no oracle by time."""
    paired: bool
    """Whether all times were measured next to the baseline's, in the same run."""
    too_close: bool
    """Whether the reference is too close to one of the cells."""


@dataclass(frozen=True)
class Mean:
    """Gains of a method at one budget, geometric mean over scenes."""

    budget: str
    method: str
    scenes: int
    """On how many scenes both it and the baseline were measured."""
    gain_samples: Interval
    gain_time: Interval
    gain_trimmed: Interval
    worst: float
    """Least gain_samples of any scene."""
    worst_scene: str
    worst_time: float
    """Least gain_time of any scene."""
    oracle_share: float | None
    """log(gain_samples) over log(limit), both means over the scenes where there is something to gain."""
    oracle_time_share: float | None


SCORES = tuple(Scores.__dataclass_fields__)
