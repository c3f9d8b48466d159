"""What the best allocation could gain: the oracle, which knows the variance of every pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tracer import objective, score

LEAST_LIMIT = 1.1
"""Below it there is so little to gain that the share of it means nothing."""


def limit(variance: ArrayLike, mean: ArrayLike, name: str) -> float:
    """Return the most that equal samples can gain, 1 + CV^2 of s sqrt(w) (Neyman, 1934).

    ``variance`` of one sample and ``mean`` are (H, W, 3); ``name`` is the objective that w belongs to. For independent
    samples without a least number; a low-discrepancy sequence can gain less or more.
    """
    weight = objective.weights(name, score.luminance(mean))
    deviation = np.sqrt(np.asarray(variance, np.float64).sum(axis=-1) * weight)
    average = float(deviation.mean())
    return float(np.mean(deviation**2)) / average**2 if average > 0 else 1.0


def share(gain: float, most: float) -> float | None:
    """Return log(gain) / log(most): the part of the limit captured; None where there is next to nothing to gain."""
    return float(np.log(gain) / np.log(most)) if most > LEAST_LIMIT and gain > 0 else None
