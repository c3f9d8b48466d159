"""Gains over the baseline from measurements, per scene and as means, and their share of what an oracle gains."""

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
}
"""The error that each objective minimises, as a function of the scores of a picture."""


@dataclass
class Results:
    """All that a study has measured. ``tracer.study.run.run_study`` has an example."""

    plan: Plan
    scenes: list[SceneFacts] = field(default_factory=list)
    measurements: list[Measurement] = field(default_factory=list)
    failures: list[Failure] = field(default_factory=list)
    kept: int = 0
    """Number of cells that an earlier run had rendered."""
    finished: bool = False
    """Whether all scenes are done."""

    def tables(self) -> tuple[list[Row], list[Mean]]:
        """Return a row per scene, budget and method, and a mean over scenes per budget and method."""
        gains: dict[tuple[str, str], list[Gains]] = {}
        limits: dict[tuple[str, str, str], Limits] = {}
        rows = [row for facts in self.scenes for row in self.rows_of(facts, gains, limits)]
        means = []
        for (budget, method), scene_gains in gains.items():
            overall = {
                f"gain_{name}": geometric_mean([getattr(entry, name) for entry in scene_gains]) for name in GAINS
            }
            worst = min(scene_gains, key=lambda entry: entry.samples.value)
            oracles = [limits[entry.scene, budget, method] for entry in scene_gains]
            rated = self.is_rated(method)
            means.append(
                Mean(
                    budget=budget,
                    method=method,
                    scenes=len(scene_gains),
                    **overall,
                    worst=worst.samples.value,
                    worst_scene=worst.scene,
                    worst_time=min(entry.time.value for entry in scene_gains),
                    oracle_share=mean_share(
                        [(entry.samples.value, most.samples) for entry, most in zip(scene_gains, oracles, strict=True)]
                    )
                    if rated
                    else None,
                    oracle_time_share=mean_share(
                        [(entry.time.value, most.time) for entry, most in zip(scene_gains, oracles, strict=True)]
                    )
                    if rated
                    else None,
                )
            )
        return rows, means

    def method(self, name: str) -> MethodPlan:
        """Return the plan of the method of this name."""
        return next(method for method in self.plan.methods if method.name == name)

    def is_rated(self, name: str) -> bool:
        """Return whether a method can be rated by an oracle: it adapts by a criterion, and the baseline is uniform."""
        return (
            self.method(name).criterion not in (None, "uniform")
            and self.method(self.plan.compared_with).criterion == "uniform"
        )

    def limits(self, name: str, facts: SceneFacts, gains: dict[str, Gains]) -> Limits:
        """Return what an oracle for the objective of a method gains, from the gains of all methods at a budget."""
        objective = self.method(name).objective
        oracles = {
            method.oracle: gains[method.name]
            for method in self.plan.methods
            if method.oracle and method.objective == objective and method.name in gains
        }
        scene_limit = facts.limit if objective == "relative" else None
        return Limits(
            oracles["samples"].samples.value if "samples" in oracles else scene_limit,
            oracles["time"].time.value if "time" in oracles else None,
        )

    def rows_of(
        self,
        facts: SceneFacts,
        gains: dict[tuple[str, str], list[Gains]],
        limits: dict[tuple[str, str, str], Limits],
    ) -> list[Row]:
        """Return the rows of a scene; add its gains to ``gains`` by (budget, method), and its limits to ``limits``.

        The keys of ``limits`` are (scene, budget, method).
        """
        groups: dict[tuple[str, str], dict[int, Measurement]] = {}
        for measured in self.measurements:
            if measured.cell.scene == facts.name:
                groups.setdefault((measured.cell.budget.label, measured.cell.method), {})[measured.cell.seed] = measured
        baseline = self.plan.compared_with
        baseline_groups = [list(group.values()) for (_, method), group in groups.items() if method == baseline]
        seconds = [[entry.took.seconds for entry in group] for group in baseline_groups]
        rates = {
            objective: error_rate(seconds, [[measure(entry.scores) for entry in group] for group in baseline_groups])
            for objective, measure in ERRORS.items()
        }
        rows = []
        for budget in (entry.label for entry in self.plan.budgets):
            baseline_group = groups.get((budget, baseline), {})
            by_method = {
                name: groups[budget, name]
                for name in (method.name for method in self.plan.methods)
                if (budget, name) in groups
            }
            pairs = {
                name: [(entry, baseline_group[seed]) for seed, entry in group.items() if seed in baseline_group]
                for name, group in by_method.items()
            }
            objectives = {name: self.method(name).objective for name in by_method}
            compared = {
                name: compare(paired, rates[objectives[name]], ERRORS[objectives[name]])
                for name, paired in pairs.items()
                if paired
            }
            for name, group in by_method.items():
                limits[facts.name, budget, name] = most = self.limits(name, facts, compared)
                if name in compared:
                    gains.setdefault((budget, name), []).append(compared[name])
                rows.append(self.summarise(list(group.values()), pairs[name], compared.get(name), facts, most))
        return rows

    def summarise(
        self,
        group: Sequence[Measurement],
        pairs: Sequence[tuple[Measurement, Measurement]],
        gains: Gains | None,
        facts: SceneFacts,
        most: Limits,
    ) -> Row:
        """Return the row of a method on a scene at a budget.

        ``group``: its measurements; ``pairs``: those that have a counterpart by the baseline with the same seed, which
        stands second; ``gains``: its gains, None where the baseline failed; ``most``: what an oracle gains.
        """
        first = group[0].cell
        rated = gains is not None and self.is_rated(first.method)
        samples = float(np.mean([entry.took.samples for entry in group]))
        return Row(
            scene=first.scene,
            budget=first.budget.label,
            method=first.method,
            seeds=len(group),
            spp=samples / (facts.width * facts.height),
            samples=samples,
            seconds=float(np.exp(np.mean([np.log(entry.took.seconds) for entry in group]))),
            drawing=float(np.mean([entry.took.seconds_drawing / entry.took.seconds for entry in group])),
            scores=Scores(*(float(np.mean([getattr(entry.scores, name) for entry in group])) for name in SCORES)),
            **{f"gain_{name}": None if gains is None else getattr(gains, name).interval for name in GAINS},
            oracle_share=share(gains.samples.value, most.samples) if gains and rated and most.samples else None,
            oracle_time_share=share(gains.time.value, most.time) if gains and rated and most.time else None,
            paired=all(entry.took.run == counterpart.took.run for entry, counterpart in pairs),
            too_close=any(entry.too_close for entry in group),
            own={name: float(np.mean([entry.own[name] for entry in group])) for name in group[0].own},
        )


def mean_share(pairs: Sequence[tuple[float, float | None]]) -> float | None:
    """Return sum(log(gain)) / sum(log(limit)) over the pairs (gain, limit) with something to gain; None without any."""
    gainful = [(gain, most) for gain, most in pairs if most is not None and most > LEAST_LIMIT]
    if not gainful:
        return None
    gains, limits = (np.log(values).sum() for values in zip(*gainful, strict=True))
    return float(gains / limits)


def compare(pairs: Sequence[tuple[Measurement, Measurement]], rate: float, error: Callable[[Scores], float]) -> Gains:
    """Return the gains of the first measurement of each pair over the second.

    ``rate``: how fast the error of the baseline falls with time, as in ``gain``; ``error``: the error of scores.
    """
    scene, budget = pairs[0][0].cell.scene, pairs[0][0].cell.budget.label
    key = zlib.crc32(f"{scene} {budget}".encode())

    def errors(measure: Callable[[Scores], float]) -> tuple[list[float], list[float]]:
        ours, baseline = zip(*((measure(first.scores), measure(second.scores)) for first, second in pairs), strict=True)
        return list(ours), list(baseline)

    samples = [method.took.samples / baseline.took.samples for method, baseline in pairs]
    seconds = [method.took.seconds / baseline.took.seconds for method, baseline in pairs]
    whole, trimmed = errors(error), errors(lambda scores: scores.relative_mse_trimmed)
    return Gains(
        scene,
        gain(*whole, samples, key=key),
        gain(*whole, seconds, rate, key),
        gain(*trimmed, samples, key=key),
        gain(*trimmed, seconds, rate, key),
    )
