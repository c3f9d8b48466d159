"""How far the times of a study can be trusted, by how much they vary where they should not."""

from __future__ import annotations

import numpy as np

from tracer.study.results import Results

LARGE_SPREAD = 0.1
"""Spread of times from which on gains at equal time are called noise: few differences between methods are larger."""
MOST_NAMED = 3
"""Most scenes and budgets that the warning names."""


def clock_spread(results: Results, scene: str, budget: str) -> float | None:
    """Return by what part the time of a sample varies by chance from picture to picture; None if that is not known.

    It is the standard deviation of the logarithm of seconds per sample, after each method's mean and each seed's mean
    (a machine that is slower for a while is slower for all methods) have been subtracted: what is left over in a
    two-way analysis of variance. It needs two methods and two seeds.
    """
    times: dict[str, dict[int, float]] = {}
    for measured in results.measurements:
        cell, took = measured.cell, measured.took
        if (cell.scene, cell.budget.label) == (scene, budget):
            times.setdefault(cell.method, {})[cell.seed] = float(np.log(took.seconds / took.samples))
    seeds = sorted(set.intersection(*map(set, times.values()))) if times else []
    if len(times) < 2 or len(seeds) < 2:
        return None
    table = np.array([[of_method[seed] for seed in seeds] for of_method in times.values()])
    rest = table - table.mean(axis=1, keepdims=True) - table.mean(axis=0, keepdims=True) + table.mean()
    return float(np.sqrt((rest**2).sum() / ((len(times) - 1) * (len(seeds) - 1))))


def clock_warning(results: Results) -> str | None:
    """Return a sentence that names where gains at equal time are mostly noise; None if they are nowhere."""
    seconds: dict[tuple[str, str], list[float]] = {}
    for measured in results.measurements:
        key = measured.cell.scene, measured.cell.budget.label
        seconds.setdefault(key, []).append(measured.took.seconds)
    spreads = {key: spread for key in seconds if (spread := clock_spread(results, *key)) is not None}
    noisy = sorted((key for key, spread in spreads.items() if spread > LARGE_SPREAD), key=lambda key: -spreads[key])
    if not noisy:
        return None
    named = [
        f"{scene} at {budget} ({100 * spreads[scene, budget]:.0f} % of {np.median(seconds[scene, budget]):.2g} s)"
        for scene, budget in noisy[:MOST_NAMED]
    ]
    more = f" and {len(noisy) - MOST_NAMED} more" if len(noisy) > MOST_NAMED else ""
    return (
        "The clock alone varies so much from picture to picture that gains at equal time are mostly noise on "
        f"{', '.join(named)}{more}: look at equal samples there, or render larger pictures or more samples."
    )
