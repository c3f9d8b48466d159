"""From importance to whole numbers of samples per pixel that add up exactly.

All but ``serve`` compute on the device, and take and return flat device arrays, mi.Float64 unless said otherwise. Sums
do not depend on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.core.arrays import Floats, spread_out
from tracer.core.reductions import largest, running_sum, sums
from tracer.errors import BudgetError

SAMPLED_PIXELS, SUITED_STEPS = 4096, 14
"""SAMPLED_PIXELS: number of pixels, about, that are examined to find a first level, or the shift with which rounded
counts add up. SUITED_STEPS: steps of the bisection that finds that shift."""
MOST_STEPS = 200
"""Most steps in the search for a level. It takes two to four, unless importance spans many orders of magnitude."""
LEAST_WEIGHT = 1e-6
"""Added to every importance, relative to the largest: a pixel without importance gets samples when others are full."""


def fill(importance: Any, total: float, lower: Any, upper: Any) -> Any:
    """Return counts n_i = clip(c w_i, lower_i, upper_i), with the c for which they sum to ``total``.

    Importance w_i >= 0 and bounds have the same size; bounds may be numbers. These counts minimise
    sum w_i^2 / n_i within the bounds (Neyman allocation with a floor and a ceiling, "water filling"). An importance
    that is zero everywhere is taken as constant. Raises BudgetError when the bounds leave no solution.
    """
    weights, least, most = checked(importance, total, lower, upper)
    return filled(weights, total, least, most)


def fill_about(importance: Any, total: float, lower: Any, upper: Any) -> Any:
    """Return counts like those of ``fill``, whose sum may differ from ``total`` by some percent, in less time."""
    weights, least, most = checked(importance, total, lower, upper)
    return dr.clip(dr.opaque(mi.Float64, level_of_some(weights, total, least, most)) * weights, least, most)


def checked(importance: Any, total: float, lower: Any, upper: Any) -> tuple[Any, Any, Any]:
    """Return (weights > 0, least, most) for the arguments of ``fill``, or raise what it raises."""
    least, most = bounds(lower, upper, dr.width(importance))
    is_wrong = dr.select(dr.isfinite(importance) & (importance >= 0), mi.Float64(0), mi.Float64(1))
    wrong_count, least_sum, most_sum = sums(is_wrong, least, most)
    if wrong_count:
        raise ValueError("importance must be finite and not negative")
    slack = 1e-9 * max(total, 1.0)
    if least_sum > total + slack or most_sum < total - slack:
        raise BudgetError(
            f"No allocation of {total:.0f} samples fits: the bounds on the samples per pixel ask for at least "
            f"{least_sum:.0f} and at most {most_sum:.0f}; change spp, min_spp or max_spp."
        )
    peak = largest(importance)
    if peak == 0:
        return dr.ones(mi.Float64, dr.width(importance)), least, most
    return importance * dr.opaque(mi.Float64, 1.0 / peak) + LEAST_WEIGHT, least, most


def bounds(lower: Any, upper: Any, size: int) -> tuple[Any, Any]:
    """Return least and most counts as arrays of ``size`` entries, of which the most are not below the least."""
    least, most = (
        dr.opaque(mi.Float64, bound, size) if isinstance(bound, int | float) else mi.Float64(bound)
        for bound in (lower, upper)
    )
    return least, dr.maximum(most, least)


def filled(weights: Any, total: float, lower: Any, upper: Any) -> Any:
    """Return counts as ``fill`` does, of weights > 0 and bounds that are known to leave a solution."""
    dr.eval(weights, lower, upper)

    def of_all(level: float) -> tuple[float, float]:
        scaled = dr.opaque(mi.Float64, level) * weights
        is_between = (scaled > lower) & (scaled < upper)
        reached, slope = sums(dr.clip(scaled, lower, upper), dr.select(is_between, weights, mi.Float64(0)))
        return reached, slope

    level = solve_level(of_all, total, level_of_some(weights, total, lower, upper), 1e-12)
    return dr.clip(dr.opaque(mi.Float64, level) * weights, lower, upper)


def level_of_some(weights: Any, total: float, lower: Any, upper: Any) -> float:
    """Return c with sum clip(c w, lower, upper) = ``total``, about, as some evenly spread pixels tell."""
    some_weights, some_lower, some_upper = some_of(weights, lower, upper)
    goal = total * len(some_weights) / dr.width(weights)
    goal = float(np.clip(goal, some_lower.sum(), some_upper.sum()))

    def of_some(level: float) -> tuple[float, float]:
        scaled = level * some_weights
        is_between = (scaled > some_lower) & (scaled < some_upper)
        return float(np.clip(scaled, some_lower, some_upper).sum()), float(some_weights[is_between].sum())

    return solve_level(of_some, goal, goal / float(some_weights.sum()), 1e-6)


def solve_level(
    of_level: Callable[[float], tuple[float, float]], total: float, guess: float, tolerance: float
) -> float:
    """Return c with f(c) = ``total`` up to the relative ``tolerance``, searched from ``guess``.

    ``of_level`` returns f(c) and its slope; f does not decrease and is piecewise linear. Newton's method is exact as
    soon as it is on the right piece; a bracket makes sure that it gets there: a step that would leave it goes to its
    middle, or, while nothing is known to be too much, to twice the level.
    """
    below, above, level = 0.0, np.inf, guess
    for _ in range(MOST_STEPS):
        reached, slope = of_level(level)
        missing = total - reached
        if abs(missing) <= tolerance * total:
            break
        below, above = (level, above) if missing > 0 else (below, level)
        level = level + missing / slope if slope > 0 else np.inf
        if not below < level < above:
            level = 2 * below if above == np.inf else 0.5 * (below + above)
    return level


def some_of(*arrays: Any) -> list[Floats]:
    """Return some entries of device arrays of the same size as NumPy, evenly spread and the same of each."""
    chosen = spread_out(dr.width(arrays[0]), SAMPLED_PIXELS)
    count = len(range(0, dr.width(arrays[0]), chosen.step))
    index = dr.opaque(mi.UInt32, chosen.step) * dr.arange(mi.UInt32, count)
    dr.eval(arrays)
    some = [dr.gather(mi.Float64, array, index) for array in arrays]
    dr.eval(some)
    return [values.numpy() for values in some]


def powers_of_two(target: Any, total: float, lower: Any, upper: Any) -> tuple[Callable[[float], Any], float]:
    """Return a function from a shift to powers of two near ``target`` times 2^shift, and the shift for ``total``.

    Counts are within the bounds, and their sum with that shift is about ``total``, as some evenly spread pixels tell.
    """
    level = dr.log2(dr.maximum(target, 1e-9))
    some_levels, some_lower, some_upper = some_of(level, lower, upper)
    goal = total * len(some_levels) / dr.width(target)

    def rounded(shift: float) -> Any:
        return dr.clip(dr.exp2(dr.round(level + dr.opaque(mi.Float64, shift))), lower, upper)

    low, high = -1.0, 1.0
    for _ in range(SUITED_STEPS):
        middle = (low + high) / 2
        is_enough = np.clip(np.exp2(np.rint(some_levels + middle)), some_lower, some_upper).sum() > goal
        low, high = (low, middle) if is_enough else (middle, high)
    return rounded, low


def suit_sequence(target: Any, total: float, lower: Any, upper: Any) -> Any:
    """Return counts near ``target`` that sum to ``total``, most of them powers of two, within the bounds.

    A low-discrepancy sequence is at its best at powers of two: between them its error is 2 to 10 % above the power law
    through them. To round a count by a factor of up to sqrt(2) costs 2 or 3 %. Samples that rounding leaves over go to
    the pixels that lack most. The sum of ``target`` may differ from ``total`` by some percent.
    """
    least, most = bounds(lower, upper, dr.width(target))
    dr.eval(target, least, most)
    rounded, shift = powers_of_two(target, total, least, most)
    while (reached := sums(counts := rounded(shift))[0]) > total and shift > -2.0:
        shift -= 0.02
    ideal = dr.maximum(target, 1e-9)
    return filled(ideal, total, counts if reached <= total else least, most)


def round_to_total(counts: Any, total: int, generator: np.random.Generator) -> Any:
    """Return real counts rounded to integers (mi.UInt32) that sum to ``total`` and whose expectations are the counts.

    Systematic sampling: with a single random offset for the running sum of all fractions, each count is rounded up or
    down. Raises ValueError if the counts do not sum to ``total``.
    """
    floors = dr.floor(counts + 1e-9)
    fraction = dr.clip(counts - floors, 0.0, 1.0)
    floor_sum, fraction_sum = sums(floors, fraction)
    remaining = total - int(floor_sum)
    if not 0 <= remaining <= np.ceil(fraction_sum + 1e-3):
        raise ValueError(f"counts sum to {floor_sum + fraction_sum}, not to {total}")
    if remaining == 0:
        return mi.UInt32(floors)
    running = running_sum(fraction) * dr.opaque(mi.Float64, remaining / fraction_sum)
    lane, last = dr.arange(mi.UInt32, dr.width(counts)), dr.opaque(mi.UInt32, dr.width(counts) - 1)
    end = dr.opaque(mi.Float64, remaining)
    running = dr.select(lane == last, end, dr.minimum(running, end))
    steps = dr.floor(running + dr.opaque(mi.Float64, generator.random()))
    before = dr.select(lane == 0, 0.0, dr.gather(mi.Float64, steps, dr.maximum(lane, 1) - 1))
    return mi.UInt32(floors + steps - before)


def serve(
    priority: ArrayLike, total: int, drawn: NDArray[np.uint32], most: int, generator: np.random.Generator
) -> NDArray[np.uint32]:
    """Return counts that sum to ``total``: pixels of highest priority come first and get as many again as they have.

    The order of pixels of the same priority is left to chance. If samples are left when all have been served, it starts
    again from the top. Pixels of priority 0 get samples only when all others have ``most``. Raises BudgetError when all
    pixels have.
    """
    values = np.asarray(priority, np.float64).ravel()
    order = np.lexsort((generator.random(values.size), -values))
    counts = drawn.ravel().astype(np.int64)
    for waiting in (order[values[order] > 0], order):
        while (remaining := total - int(counts.sum())) > 0:
            step = np.minimum(np.maximum(counts[waiting], 1), np.maximum(most - counts[waiting], 0))
            if not step.any():
                break
            served = np.cumsum(step) - step
            counts[waiting] += np.clip(remaining - served, 0, step)
    if remaining > 0:
        raise BudgetError(f"No allocation of {total} samples fits: no pixel may have more than {most}.")
    return counts.reshape(drawn.shape).astype(np.uint32)
