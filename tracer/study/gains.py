"""Gains over a baseline, with bootstrap intervals over seeds: pure functions of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
RESAMPLES = 4000
LEVEL = 0.95
TINY = 1e-30
"""Added to errors, so that two perfect pictures are equally good."""
SLOWEST, FASTEST = 0.5, 1.5
"""Bounds of a believable rate b at which an error falls as 1 / seconds^b."""


@dataclass(frozen=True)
class Interval:
    """A value and its 95 % interval; NaN where one seed alone leaves it unknown."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Gain:
    """How many times smaller than the baseline's an error is, and the same for resampled seeds."""

    value: float
    resampled: Floats
    """(RESAMPLES,)."""

    @property
    def interval(self) -> Interval:
        """The percentile interval."""
        return percentiles(self.value, self.resampled)


def gain(errors: ArrayLike, baseline: ArrayLike, cost: ArrayLike, rate: float = 1.0, key: int = 0) -> Gain:
    """Return mean(baseline) / mean(errors) / cost^rate over seeds: all arrays (S,), one entry a seed, seeds paired.

    ``cost`` is what the method used over what the baseline used, samples or seconds, and counts by its geometric mean.
    ``rate`` is how fast the baseline's error falls with it. ``key`` seeds the resampling.
    """
    errors, baseline, cost = (np.asarray(values, np.float64) for values in (errors, baseline, cost))
    seeds = len(errors)
    picks = np.random.default_rng([key, seeds]).integers(0, seeds, (RESAMPLES, seeds))

    def of(pick: NDArray) -> Floats:
        ratio = (baseline[pick].mean(axis=-1) + TINY) / (errors[pick].mean(axis=-1) + TINY)
        return ratio / np.exp(rate * np.log(cost[pick]).mean(axis=-1))

    return Gain(float(of(np.arange(seeds))), of(picks))


def geometric_mean(gains: Sequence[Gain]) -> Interval:
    """Return the geometric mean over scenes; the interval is over the seeds of each, the scenes being what they are."""
    logarithms = np.mean([np.log(one.resampled) for one in gains], axis=0)
    value = float(np.exp(np.mean([np.log(one.value) for one in gains])))
    return percentiles(value, np.exp(logarithms))


def percentiles(value: float, resampled: Floats) -> Interval:
    """Return the interval between the outer percentiles, unknown if all resamples are the same."""
    if np.ptp(resampled) == 0:
        return Interval(value, float("nan"), float("nan"))
    low, high = np.quantile(resampled, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Interval(value, float(low), float(high))


def error_rate(seconds: ArrayLike, errors: ArrayLike) -> float:
    """Return b of errors ~ seconds^-b by least squares on logarithms, within believable bounds; 1 from one budget."""
    seconds, errors = np.asarray(seconds, np.float64), np.asarray(errors, np.float64)
    usable = (errors > 0) & (seconds > 0)
    if len(np.unique(seconds[usable])) < 2:
        return 1.0
    slope = np.polyfit(np.log(seconds[usable]), np.log(errors[usable]), 1)[0]
    return float(np.clip(-slope, SLOWEST, FASTEST))
