"""From importance to whole numbers of samples per pixel that add up exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.core.arrays import Floats, spread_out
from tracer.errors import BudgetError

SUITED_PIXELS, SUITED_STEPS = 4096, 14
"""SUITED_PIXELS: number of pixels that are examined to find the shift with which rounded counts add up. SUITED_STEPS:
steps of the bisection that finds it."""


def fill(importance: ArrayLike, total: float, lower: ArrayLike, upper: ArrayLike) -> Floats:
    """Return counts n_i = clip(c w_i, lower_i, upper_i), with the c for which they sum to ``total``.

    Importance w_i >= 0 and bounds are arrays of the same shape; bounds may be scalars. These counts minimise
    sum w_i^2 / n_i within the bounds (Neyman allocation with a floor and a ceiling, "water filling"). An importance
    that is zero everywhere is taken as constant. Raises BudgetError when the bounds leave no solution.
    """
    weights = np.asarray(importance, np.float64)
    if not np.all(np.isfinite(weights)) or np.any(weights < 0):
        raise ValueError("importance must be finite and not negative")
    least = np.broadcast_to(np.asarray(lower, np.float64), weights.shape)
    most = np.maximum(np.broadcast_to(np.asarray(upper, np.float64), weights.shape), least)
    slack = 1e-9 * max(total, 1.0)
    if least.sum() > total + slack or most.sum() < total - slack:
        raise BudgetError(
            f"No allocation of {total:.0f} samples fits: the bounds on the samples per pixel ask for at least "
            f"{least.sum():.0f} and at most {most.sum():.0f}; change spp, min_spp or max_spp."
        )
    peak = weights.max(initial=0.0)
    # A pixel without importance gets samples only when all others are full.
    weights = weights / peak + 1e-6 if peak > 0 else np.ones_like(weights)
    return np.clip(solve_level(weights, total, least, most) * weights, least, most)


def solve_level(weights: Floats, total: float, lower: Floats, upper: Floats) -> float:
    """Return c with sum clip(c w, lower, upper) = total.

    The sum is piecewise linear in c. Newton's method is exact as soon as it is on the right piece; a bracket, which is
    halved when a step would leave it, makes sure that it gets there.
    """
    below, above = 0.0, float(np.max(upper / weights))
    level = total / float(weights.sum())
    for _ in range(200):
        scaled = level * weights
        missing = total - float(np.clip(scaled, lower, upper).sum())
        if abs(missing) <= 1e-12 * total:
            break
        below, above = (level, above) if missing > 0 else (below, level)
        slope = float(weights[(scaled > lower) & (scaled < upper)].sum())
        level = level + missing / slope if slope > 0 else above
        if not below < level < above:
            level = 0.5 * (below + above)
    return level


def suit_sequence(target: ArrayLike, total: float, lower: ArrayLike, upper: ArrayLike) -> Floats:
    """Return counts near ``target`` that sum to ``total``, most of them powers of two, within the bounds.

    A low-discrepancy sequence is at its best at powers of two: between them its error is 2 to 10 % above the power law
    through them. To round a count by a factor of up to sqrt(2) costs 2 or 3 %. Samples that rounding leaves over go to
    the pixels that lack most.
    """
    ideal = np.maximum(np.asarray(target, np.float64), 1e-9)
    least = np.broadcast_to(np.asarray(lower, np.float64), ideal.shape)
    most = np.maximum(np.broadcast_to(np.asarray(upper, np.float64), ideal.shape), least)
    level = np.log2(ideal)
    sampled = spread_out(ideal.size, SUITED_PIXELS)
    sampled_arrays = [np.ascontiguousarray(array.ravel()[sampled]) for array in (level, least, most)]

    def rounded(shift: float, level: Floats, least: Floats, most: Floats) -> Floats:
        return np.clip(np.exp2(np.rint(level + shift)), least, most)

    low, high = -1.0, 1.0
    for _ in range(SUITED_STEPS):
        middle = (low + high) / 2
        is_enough = rounded(middle, *sampled_arrays).sum() * ideal.size > total * sampled_arrays[0].size
        low, high = (low, middle) if is_enough else (middle, high)
    counts = rounded(low, level, least, most)
    while counts.sum() > total and low > -2.0:
        low -= 0.02
        counts = rounded(low, level, least, most)
    return fill(ideal, total, counts, most) if counts.sum() <= total else ideal


def round_to_total(counts: ArrayLike, total: int, generator: np.random.Generator) -> NDArray[np.uint32]:
    """Return real counts (any shape) rounded to integers that sum to ``total`` and whose expectations are the counts.

    Systematic sampling: with a single random offset for the running sum of all fractions, each count is rounded up or
    down. Raises ValueError if the counts do not sum to ``total``.
    """
    counts = np.asarray(counts, np.float64)
    floors = np.floor(counts + 1e-9)
    fraction = np.clip(counts - floors, 0.0, 1.0).ravel()
    remaining = total - int(floors.sum())
    if not 0 <= remaining <= np.ceil(fraction.sum() + 1e-3):
        raise ValueError(f"counts sum to {counts.sum()}, not to {total}")
    if remaining == 0:
        return floors.astype(np.uint32)
    running = np.cumsum(fraction) * (remaining / fraction.sum())
    running = np.minimum(running, remaining)
    running[-1] = remaining
    extra = np.diff(np.floor(running + generator.random()), prepend=0.0)
    return (floors + extra.reshape(counts.shape)).astype(np.uint32)


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
