"""What denoising does to the error of the same samples: a table for every two methods that differ in nothing else."""

from __future__ import annotations

import zlib
from collections.abc import Callable

import numpy as np

from tracer.image.metrics import Scores
from tracer.study.gains import Gain, Interval, gain, geometric_mean
from tracer.study.plan import Plan
from tracer.study.results import Results

ERRORS: dict[str, Callable[[Scores], float]] = {
    "relMSE": lambda scores: scores.relative_mse,
    "trimmed": lambda scores: scores.relative_mse_trimmed,
}
"""The errors that are compared, by their names in tables."""


def pairs(plan: Plan) -> list[tuple[str, str]]:
    """Return the names (noisy, denoised) of the methods of a plan that differ in nothing but denoising."""
    settings = {method.name: method.model_dump(exclude={"name", "denoise"}) for method in plan.methods}
    return [
        (noisy.name, denoised.name)
        for denoised in plan.methods
        for noisy in plan.methods
        if denoised.denoise and not noisy.denoise and settings[noisy.name] == settings[denoised.name]
    ]


def ratio(results: Results, scene: str, budget: str, names: tuple[str, str], error: str) -> Gain | None:
    """Return an error of denoised pictures over that of noisy ones, ratio of means over seeds.

    ``names``: of the noisy and the denoised method. None where a method has no picture.
    """
    by_method: list[dict[int, float]] = [
        {
            measured.cell.seed: ERRORS[error](measured.scores)
            for measured in results.measurements
            if (measured.cell.scene, measured.cell.budget.label, measured.cell.method) == (scene, budget, name)
        }
        for name in names
    ]
    seeds = sorted(by_method[0].keys() & by_method[1].keys())
    if not seeds:
        return None
    noisy, denoised = ([errors[seed] for seed in seeds] for errors in by_method)
    # The gain of the noisy picture over the denoised one, which is above 1 where denoising harms.
    return gain(noisy, denoised, np.ones(len(seeds)), key=zlib.crc32(f"{scene} {budget}".encode()))


def denoised_over_noisy(results: Results, budget: str) -> tuple[list[str], dict[str, list[Interval | None]]]:
    """Return the headings of the columns at a budget, two per pair of methods, and their values by line.

    There is a line per scene, by its name, and one for the geometric mean. Without pairs there is nothing.
    """
    columns = [(names, error) for names in pairs(results.plan) for error in ERRORS]
    ratios = {
        facts.name: [ratio(results, facts.name, budget, *column) for column in columns] for facts in results.scenes
    }
    lines = {scene: [value.interval if value else None for value in values] for scene, values in ratios.items()}
    by_column = [[value for value in values if value] for values in zip(*ratios.values(), strict=True)]
    lines["geometric mean"] = [geometric_mean(values) if values else None for values in by_column]
    return [f"{denoised} over {noisy}, {error}" for (noisy, denoised), error in columns], lines
