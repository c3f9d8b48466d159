"""By which factor the variance falls with the best choices that paths have taught, as judged by other paths."""

from __future__ import annotations

import numpy as np
from scipy.optimize import isotonic_regression

from benchmarks.guiding.paths import Choices, plan_of_directions
from tracer.core.arrays import Floats
from tracer.guiding.evidence import Taught, brightness
from tracer.guiding.learn import learn
from tracer.guiding.slots import SlotPlan
from tracer.guiding.training import Paths, Trials
from tracer.image import objective

STEPS, LEAST_CHANCE = 50, 0.01
"""Steps towards the best chances with which paths go on, and the least of them."""


def limits(choices: Choices, grid: tuple[int, int], plan: SlotPlan) -> dict[str, float]:
    """Return the factor for each kind of choice.

    ``grid``: rows and columns of the picture; ``plan``: of lights and their parts. "all" is that of lights with parts
    and both directions: what each takes from the variance adds up.
    """
    paths = choices.paths

    def gain(trials: Trials, own_plan: SlotPlan) -> float:
        lesson = learn(Taught.of(paths, [trials], grid, "relative", 0.0), own_plan)
        return lesson.gain if lesson is not None else 1.0

    found = {"lights": gain(of_whole_lights(choices.lights, plan), whole(plan)), "parts": gain(choices.lights, plan)}
    for k, trials in enumerate(choices.directions, start=1):
        found[f"directions {k}"] = gain(trials, plan_of_directions()) if len(trials.path) else 1.0
    left = 1 - sum(1 - 1 / factor for name, factor in found.items() if name != "lights")
    return {**found, "all": 1 / max(left, 0.1)}


def weights_of(paths: Paths, grid: tuple[int, int]) -> Floats:
    """Return how much the squared error of each path (paths,) counts in relMSE; ``grid``: rows and columns."""
    return objective.weights("relative", brightness(paths.chosen.pixel, paths.radiance, grid))


def whole(plan: SlotPlan) -> SlotPlan:
    """Return slots that are whole lights, or groups of them."""
    first_part = plan.part == 0
    kept = {name: getattr(plan, name)[first_part] for name in ("first", "count", "centre", "radius")}
    ones = np.ones(int(first_part.sum()), np.uint32)
    return SlotPlan(order=plan.order, side=ones, part=0 * ones, **kept)


def of_whole_lights(trials: Trials, plan: SlotPlan) -> Trials:
    """Return trials as if lights had been chosen, and not parts of them."""
    light = (np.cumsum(plan.part == 0) - 1).astype(np.uint32)
    parts = np.square(plan.side.astype(float))[trials.slot]
    chance, given = trials.chance * parts, trials.given * parts
    return Trials(trials.path, trials.position, trials.normal, light[trials.slot], chance, given)


def roulette_limit(steps: Floats, weight: Floats, costs: Floats) -> float:
    """Return the factor by which variance times cost falls if paths end at the best chance of each depth.

    ``steps`` (parts, paths): what each part of a path gives; ``weight`` (paths,): how much its square counts;
    two and two are of the same pixel; ``costs`` (parts,): of each part. If q is the chance to get
    as far as each part, the variance of a path is sum(M / q) - mean^2, where M is the part's own square and twice its
    products with the parts behind it. Every q is at most the one before.
    """
    behind = np.cumsum(steps[::-1], axis=0)[::-1] - steps
    moments = np.maximum((weight * (np.square(steps) + 2 * steps * behind)).mean(axis=1), 0)
    total = steps.sum(axis=0)
    mean_square = float((weight[::2] * total[::2] * total[1::2]).mean())

    def product(chance: Floats) -> tuple[float, float]:
        return float((moments / chance).sum()) - mean_square, float((costs * chance).sum())

    chance = np.ones(len(steps))
    before = best = float(np.prod(product(chance)))
    for _ in range(STEPS):
        variance, cost = product(chance)
        wanted = np.sqrt(moments / np.maximum(costs, 1e-12) * max(variance, 0) / cost)
        chance = np.clip(isotonic_regression(wanted, increasing=False).x, LEAST_CHANCE, 1)
        chance[0] = 1
        best = min(best, float(np.prod(product(chance))))
    return before / best if best > 0 else 1.0
