"""Numbers of a study: a line a cell, a line a method, and means over scenes."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tracer.score import Scores
from tracer.study.cells import Cell, Took
from tracer.study.gains import Gain, Interval, error_rate, gain, geometric_mean
from tracer.study.oracle import LEAST_LIMIT, share
from tracer.study.plan import Plan

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

    samples: float
    """At equal samples."""
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
    """relMSE of the baseline over that of the method, per sample; None where the baseline failed."""
    gain_time: Interval | None
    """The same per second."""
    gain_trimmed: Interval | None
    """As gain_samples, of the trimmed relMSE."""
    oracle_share: float | None
    """log(gain_samples) / log(limit), of methods that minimise the relative error, over a uniform baseline; None for
    others, and where there is next to nothing to gain. The limit is what an oracle by samples gained, if the study has
    one, else that of the scene."""
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


@dataclass
class Results:
    """All that a study found."""

    plan: Plan
    scenes: list[SceneFacts] = field(default_factory=list)
    measurements: list[Measurement] = field(default_factory=list)
    failures: list[Failure] = field(default_factory=list)
    kept: int = 0
    """Cells that were there from an earlier run."""
    finished: bool = False
    """Whether all scenes were done."""

    def tables(self) -> tuple[list[Row], list[Mean]]:
        """Return rows and means."""
        gains: dict[tuple[str, str], list[Gains]] = {}
        limits: dict[tuple[str, str], Limits] = {}
        rows = [row for facts in self.scenes for row in self.rows_of(facts, gains, limits)]
        means = []
        for (budget, method), found in gains.items():
            samples, times, trimmed = (geometric_mean([getattr(one, name) for one in found]) for name in GAINS)
            worst = min(found, key=lambda one: one.samples.value)
            most = [limits[one.scene, budget] for one in found]
            rated = self.is_rated(method)
            means.append(
                Mean(
                    budget=budget,
                    method=method,
                    scenes=len(found),
                    gain_samples=samples,
                    gain_time=times,
                    gain_trimmed=trimmed,
                    worst=worst.samples.value,
                    worst_scene=worst.scene,
                    worst_time=min(one.time.value for one in found),
                    oracle_share=mean_share([(g.samples.value, m.samples) for g, m in zip(found, most, strict=True)])
                    if rated
                    else None,
                    oracle_time_share=mean_share([(g.time.value, m.time) for g, m in zip(found, most, strict=True)])
                    if rated
                    else None,
                )
            )
        return rows, means

    def is_rated(self, name: str) -> bool:
        """Return whether a method does what an oracle of the relative error does: minimise it, against uniform."""
        own = next(method for method in self.plan.methods if method.name == name)
        against = next(method for method in self.plan.methods if method.name == self.plan.compared_with)
        return own.criterion not in (None, "uniform") and against.criterion == "uniform" and own.objective == "relative"

    def limits(self, facts: SceneFacts, found: dict[str, Gains]) -> Limits:
        """Return what an oracle gains at one budget, from the gains of all methods by name."""
        by = {
            method.oracle: found[method.name]
            for method in self.plan.methods
            if method.oracle and method.objective == "relative" and method.name in found
        }
        return Limits(
            by["samples"].samples.value if "samples" in by else facts.limit,
            by["time"].time.value if "time" in by else None,
        )

    def rows_of(
        self,
        facts: SceneFacts,
        gains: dict[tuple[str, str], list[Gains]],
        limits: dict[tuple[str, str], Limits],
    ) -> list[Row]:
        """Return the rows of a scene; add its gains by (budget, method), and its limits by (scene, budget)."""
        groups: dict[tuple[str, str], dict[int, Measurement]] = {}
        for one in self.measurements:
            if one.cell.scene == facts.name:
                groups.setdefault((one.cell.budget.label, one.cell.method), {})[one.cell.seed] = one
        baseline = self.plan.compared_with
        known = [list(group.values()) for (_, method), group in groups.items() if method == baseline]
        rate = error_rate(
            [[one.took.seconds for one in group] for group in known],
            [[one.scores.relative_mse for one in group] for group in known],
        )
        rows = []
        for budget in (one.label for one in self.plan.budgets):
            against = groups.get((budget, baseline), {})
            own = {
                name: groups[budget, name] for name in (m.name for m in self.plan.methods) if (budget, name) in groups
            }
            pairs = {
                name: [(one, against[seed]) for seed, one in group.items() if seed in against]
                for name, group in own.items()
            }
            found = {name: compare(each, rate) for name, each in pairs.items() if each}
            limits[facts.name, budget] = most = self.limits(facts, found)
            for name, group in own.items():
                if name in found:
                    gains.setdefault((budget, name), []).append(found[name])
                rows.append(self.summarise(list(group.values()), pairs[name], found.get(name), facts, most))
        return rows

    def summarise(
        self,
        group: Sequence[Measurement],
        pairs: Sequence[tuple[Measurement, Measurement]],
        found: Gains | None,
        facts: SceneFacts,
        most: Limits,
    ) -> Row:
        """Return the row of one method at one budget."""
        first = group[0].cell
        rated = found is not None and self.is_rated(first.method)
        samples = float(np.mean([one.took.samples for one in group]))
        return Row(
            scene=first.scene,
            budget=first.budget.label,
            method=first.method,
            seeds=len(group),
            spp=samples / (facts.width * facts.height),
            samples=samples,
            seconds=float(np.exp(np.mean([np.log(one.took.seconds) for one in group]))),
            drawing=float(np.mean([one.took.seconds_drawing / one.took.seconds for one in group])),
            scores=Scores(*(float(np.mean([getattr(m.scores, name) for m in group])) for name in SCORES)),
            gain_samples=None if found is None else found.samples.interval,
            gain_time=None if found is None else found.time.interval,
            gain_trimmed=None if found is None else found.trimmed.interval,
            oracle_share=share(found.samples.value, most.samples) if found and rated else None,
            oracle_time_share=share(found.time.value, most.time) if found and rated and most.time else None,
            paired=all(one.took.run == other.took.run for one, other in pairs),
            too_close=any(one.too_close for one in group),
        )


def mean_share(pairs: Sequence[tuple[float, float | None]]) -> float | None:
    """Return the share of (gain, limit) pairs together, over those where there is something to gain."""
    known = [(gain, most) for gain, most in pairs if most is not None and most > LEAST_LIMIT]
    if not known:
        return None
    gains, limits = (np.log(each).sum() for each in zip(*known, strict=True))
    return float(gains / limits)


SCORES = tuple(Scores.__dataclass_fields__)


def compare(pairs: Sequence[tuple[Measurement, Measurement]], rate: float) -> Gains:
    """Return the gains of the first of each pair over the second; ``rate`` as in ``gain``, for time."""
    scene, budget = pairs[0][0].cell.scene, pairs[0][0].cell.budget.label
    key = zlib.crc32(f"{scene} {budget}".encode())

    def errors(name: str) -> tuple[list[float], list[float]]:
        own, other = zip(*((getattr(m.scores, name), getattr(u.scores, name)) for m, u in pairs), strict=True)
        return list(own), list(other)

    samples = [m.took.samples / u.took.samples for m, u in pairs]
    seconds = [m.took.seconds / u.took.seconds for m, u in pairs]
    return Gains(
        scene,
        gain(*errors("relative_mse"), samples, key=key),
        gain(*errors("relative_mse"), seconds, rate, key),
        gain(*errors("relative_mse_trimmed"), samples, key=key),
    )
