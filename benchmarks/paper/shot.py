"""The paper's own method: patches that shoot their light, by its rules, beside random rays and a lattice."""

from __future__ import annotations

from dataclasses import astuple
from typing import Any

import numpy as np

from benchmarks.harness import Announce, ratio_over_seeds
from benchmarks.paper.methods import CLASSICAL, LATTICE
from benchmarks.radiosity.scenes import Example
from tracer.core.arrays import Floats
from tracer.radiosity.meshing import cut
from tracer.radiosity.paper import PaperRules
from tracer.radiosity.shooting import ShootingSolution, shoot
from tracer.radiosity.spread import RANDOMLY, Spread

RAYS = (128,)
"""Numbers of rays a patch on average, without those that look."""
SEEDS = 3
"""Number of seeds."""
TRUTH = 4096
"""Rays a patch of the reference."""
RESIDUAL = 1e-4
"""Share of the power that is left unsent."""
WAYS: dict[str, Spread] = {
    CLASSICAL: RANDOMLY,
    LATTICE: None,
    **{
        f"{'energies right' if right else 'as printed'}, depth {depth}": PaperRules(depth=depth, right=right)
        for right in (False, True)
        for depth in (0, 1)
    },
}
"""How rays are spread; the first is the baseline."""


def step_count() -> int:
    """Return the number of steps of a scene."""
    return 1 + len(RAYS)


def measure(example: Example, announce: Announce) -> list[dict[str, Any]]:
    """Return a row for every way and number of rays: the gain over random rays, the bias, and the share of looks.

    The error is the mean over the area of patches that do not emit of the squared error of irradiance.
    """
    announce(f"{example.name}, shooting, truth")
    patches = cut(example.scene, example.size)
    dark = patches.emitted.max(axis=1) == 0
    area = patches.areas[dark]
    truth = shoot(patches, TRUTH, RESIDUAL, 99).irradiance[dark]

    def error(solution: ShootingSolution) -> float:
        off: Floats = np.mean((solution.irradiance[dark] - truth) ** 2, axis=1)
        return float(np.average(off, weights=area))

    def brightness(irradiance: Floats) -> float:
        return float(np.average(irradiance.mean(axis=1), weights=area))

    rows = []
    for rays in RAYS:
        announce(f"{example.name}, shooting, {rays} rays")
        # Each step of a solution has a seed of its own, counted from that of the solution.
        solutions = {
            name: [shoot(patches, rays, RESIDUAL, 1000 * seed, spread) for seed in range(SEEDS)]
            for name, spread in WAYS.items()
        }
        shot = float(np.mean([solution.rays for solution in solutions[CLASSICAL]]))
        classical = [error(solution) for solution in solutions[CLASSICAL]]
        for name, found in solutions.items():
            if name == CLASSICAL:
                continue
            means = [brightness(solution.irradiance[dark]) for solution in found]
            rows.append(
                {
                    "scene": example.name,
                    "rays": rays,
                    "method": name,
                    "gain": astuple(ratio_over_seeds([error(solution) for solution in found], classical)),
                    "bias": float(np.mean(means)) / brightness(truth) - 1,
                    "traced": float(np.mean([solution.rays for solution in found])) / shot,
                }
            )
    return rows
