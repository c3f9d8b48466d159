"""Importance to integer samples per pixel that add up exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.core.arrays import Floats, spread_out
from tracer.errors import BudgetError

SUITED_PIXELS, SUITED_STEPS = 4096, 14
"""How many pixels are looked at to find what makes rounded counts add up, and in how many steps."""


def fill(importance: ArrayLike, total: float, lower: ArrayLike, upper: ArrayLike) -> Floats:
    """Return counts n_i = clip(c w_i, lower_i, upper_i), with the one c for which they sum to ``total``.

    Importance w_i >= 0 and bounds are arrays of one shape (or scalars for the bounds). This minimises
    sum w_i^2 / n_i within the bounds (Neyman allocation with a floor and a ceiling, "water filling"). Where the whole
    importance is zero it is taken as constant. Raises BudgetError when the bounds leave no solution.
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
    # A pixel of no importance takes samples only when all others are full.
    weights = weights / peak + 1e-6 if peak > 0 else np.ones_like(weights)
    return np.clip(solve_level(weights, total, least, most) * weights, least, most)


def solve_level(weights: Floats, total: float, lower: Floats, upper: Floats) -> float:
    """Return c with sum clip(c w, lower, upper) = total.

    The sum is piecewise linear in c: Newton's method ends exactly once it is on the right piece, and a bracket that is
    halved when a step leaves it makes sure that it gets there.
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

    A low-discrepancy sequence is at its best there: between them its error is 2 to 10 % above the power law through
    them. To round a count by up to sqrt(2) costs 2 or 3 %. What rounding leaves over goes where it is missed most.
    """
    wanted = np.maximum(np.asarray(target, np.float64), 1e-9)
    least = np.broadcast_to(np.asarray(lower, np.float64), wanted.shape)
    most = np.maximum(np.broadcast_to(np.asarray(upper, np.float64), wanted.shape), least)
    level = np.log2(wanted)
    few = spread_out(wanted.size, SUITED_PIXELS)
    some = [np.ascontiguousarray(array.ravel()[few]) for array in (level, least, most)]

    def rounded(shift: float, level: Floats, least: Floats, most: Floats) -> Floats:
        return np.clip(np.exp2(np.rint(level + shift)), least, most)

    low, high = -1.0, 1.0
    for _ in range(SUITED_STEPS):
        middle = (low + high) / 2
        enough = rounded(middle, *some).sum() * wanted.size > total * some[0].size
        low, high = (low, middle) if enough else (middle, high)
    counts = rounded(low, level, least, most)
    while counts.sum() > total and low > -2.0:
        low -= 0.02
        counts = rounded(low, level, least, most)
    return fill(wanted, total, counts, most) if counts.sum() <= total else wanted


def round_to_total(counts: ArrayLike, total: int, generator: np.random.Generator) -> NDArray[np.uint32]:
    """Round real counts (any shape) to integers that sum to ``total``, each with the real count as its expectation.

    Systematic sampling: one random offset for the running sum of all fractions, so a count is its floor or one more.
    """
    counts = np.asarray(counts, np.float64)
    whole = np.floor(counts + 1e-9)
    fraction = np.clip(counts - whole, 0.0, 1.0).ravel()
    left = total - int(whole.sum())
    if not 0 <= left <= np.ceil(fraction.sum() + 1e-3):
        raise ValueError(f"counts sum to {counts.sum()}, not to {total}")
    if left == 0:
        return whole.astype(np.uint32)
    running = np.cumsum(fraction) * (left / fraction.sum())
    running = np.minimum(running, left)
    running[-1] = left
    extra = np.diff(np.floor(running + generator.random()), prepend=0.0)
    return (whole + extra.reshape(counts.shape)).astype(np.uint32)


def serve(
    priority: ArrayLike, total: int, drawn: NDArray[np.uint32], most: int, generator: np.random.Generator
) -> NDArray[np.uint32]:
    """Return counts that sum to ``total``: pixels of highest priority first, each getting as many again as it has.

    Which of two pixels of the same priority is first is left to chance. When all have been served and samples are left,
    it starts again from the top. Pixels of priority 0 get none unless all others have ``most``. Raises BudgetError when
    all have.
    """
    values = np.asarray(priority, np.float64).ravel()
    order = np.lexsort((generator.random(values.size), -values))
    counts = drawn.ravel().astype(np.int64)
    for waiting in (order[values[order] > 0], order):
        while (left := total - int(counts.sum())) > 0:
            step = np.minimum(np.maximum(counts[waiting], 1), np.maximum(most - counts[waiting], 0))
            if not step.any():
                break
            before = np.cumsum(step) - step
            counts[waiting] += np.clip(left - before, 0, step)
    if left > 0:
        raise BudgetError(f"No allocation of {total} samples fits: no pixel may have more than {most}.")
    return counts.reshape(drawn.shape).astype(np.uint32)
