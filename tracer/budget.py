"""Importance to integer samples per pixel that add up exactly."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.errors import BudgetError

Floats = NDArray[np.float64]


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


def serve(priority: ArrayLike, total: int, drawn: NDArray[np.uint32], most: int) -> NDArray[np.uint32]:
    """Return counts that sum to ``total``: pixels of highest priority first, each getting as many again as it has.

    When all have been served and samples are left, it starts again from the top. Pixels of priority 0 get none unless
    all others have ``most``. Raises BudgetError when all have.
    """
    values = np.asarray(priority, np.float64).ravel()
    order = np.argsort(-values, kind="stable")
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
