"""From measurements to gains over the baseline, per scene and as means, and to the share of what an oracle gains."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from tracer.image.metrics import Scores
from tracer.study.gains import error_rate, gain, geometric_mean
from tracer.study.oracle import LEAST_LIMIT, share
from tracer.study.plan import MethodPlan, Plan
from tracer.study.records import GAINS, SCORES, Failure, Gains, Limits, Mean, Measurement, Row, SceneFacts

ERRORS: dict[str, Callable[[Scores], float]] = {
    "relative": lambda scores: scores.relative_mse,
    "absolute": lambda scores: scores.mse,
    "display": lambda scores: 10 ** (-scores.psnr / 10),
    "denoised": lambda scores: scores.relative_mse,
}
"""The error that each objective is after."""


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
        limits: dict[tuple[str, str, str], Limits] = {}
        rows = [row for facts in self.scenes for row in self.rows_of(facts, gains, limits)]
        means = []
        for (budget, method), found in gains.items():
            samples, times, trimmed = (geometric_mean([getattr(one, name) for one in found]) for name in GAINS)
            worst = min(found, key=lambda one: one.samples.value)
            most = [limits[one.scene, budget, method] for one in found]
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

    def method(self, name: str) -> MethodPlan:
        """Return the plan of a method."""
        return next(method for method in self.plan.methods if method.name == name)

    def is_rated(self, name: str) -> bool:
        """Return whether a method does what an oracle does: minimise an error, against uniform."""
        return (
            self.method(name).criterion not in (None, "uniform")
            and self.method(self.plan.compared_with).criterion == "uniform"
        )

    def limits(self, name: str, facts: SceneFacts, found: dict[str, Gains]) -> Limits:
        """Return what an oracle of the objective of a method gains, from the gains of all methods at a budget."""
        objective = self.method(name).objective
        by = {
            method.oracle: found[method.name]
            for method in self.plan.methods
            if method.oracle and method.objective == objective and method.name in found
        }
        known = facts.limit if objective == "relative" else None
        return Limits(
            by["samples"].samples.value if "samples" in by else known,
            by["time"].time.value if "time" in by else None,
        )

    def rows_of(
        self,
        facts: SceneFacts,
        gains: dict[tuple[str, str], list[Gains]],
        limits: dict[tuple[str, str, str], Limits],
    ) -> list[Row]:
        """Return the rows of a scene; add its gains by (budget, method), and its limits by (scene, budget, method)."""
        groups: dict[tuple[str, str], dict[int, Measurement]] = {}
        for one in self.measurements:
            if one.cell.scene == facts.name:
                groups.setdefault((one.cell.budget.label, one.cell.method), {})[one.cell.seed] = one
        baseline = self.plan.compared_with
        known = [list(group.values()) for (_, method), group in groups.items() if method == baseline]
        seconds = [[one.took.seconds for one in group] for group in known]
        rates = {
            objective: error_rate(seconds, [[measure(one.scores) for one in group] for group in known])
            for objective, measure in ERRORS.items()
        }
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
            objectives = {name: self.method(name).objective for name in own}
            found = {
                name: compare(each, rates[objectives[name]], ERRORS[objectives[name]])
                for name, each in pairs.items()
                if each
            }
            for name, group in own.items():
                limits[facts.name, budget, name] = most = self.limits(name, facts, found)
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
            oracle_share=share(found.samples.value, most.samples) if found and rated and most.samples else None,
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


def compare(pairs: Sequence[tuple[Measurement, Measurement]], rate: float, error: Callable[[Scores], float]) -> Gains:
    """Return the gains of the first of each pair over the second; ``rate`` as in ``gain``, for time."""
    scene, budget = pairs[0][0].cell.scene, pairs[0][0].cell.budget.label
    key = zlib.crc32(f"{scene} {budget}".encode())

    def errors(measure: Callable[[Scores], float]) -> tuple[list[float], list[float]]:
        own, other = zip(*((measure(m.scores), measure(u.scores)) for m, u in pairs), strict=True)
        return list(own), list(other)

    samples = [m.took.samples / u.took.samples for m, u in pairs]
    seconds = [m.took.seconds / u.took.seconds for m, u in pairs]
    return Gains(
        scene,
        gain(*errors(error), samples, key=key),
        gain(*errors(error), seconds, rate, key),
        gain(*errors(lambda scores: scores.relative_mse_trimmed), samples, key=key),
    )
