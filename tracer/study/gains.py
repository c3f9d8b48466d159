"""Gains over a baseline, with bootstrap intervals over seeds: pure functions of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from tracer.core.arrays import Floats

RESAMPLES = 8000
"""Number of bootstrap resamples that an interval is taken from."""
LEVEL = 0.95
"""Probability with which an interval is meant to hold the true value."""
TINY = 1e-30
"""Added to mean errors, so that two perfect pictures are equally good."""
SLOWEST, FASTEST = 0.5, 1.5
"""Bounds of the rate b at which an error can be believed to fall as 1 / seconds^b."""


@dataclass(frozen=True)
class Interval:
    """A value and the bounds of its 95 % interval, which are NaN where the value has only one seed."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Gain:
    """How many times smaller than the error of the baseline an error is, and the same for resampled seeds."""

    value: float
    resampled: Floats
    """(RESAMPLES,): the gain of each resample of the seeds."""
    seeds: int
    """Number of seeds."""

    @property
    def interval(self) -> Interval:
        """The gain and its 95 % interval, see ``percentiles``."""
        return percentiles(self.value, self.resampled, self.seeds)


def gain(errors: ArrayLike, baseline: ArrayLike, cost: ArrayLike, rate: float = 1.0, key: int = 0) -> Gain:
    """Return mean(baseline) / mean(errors) / cost^rate over seeds: all arrays (S,), one entry per seed, seeds paired.

    ``cost`` is the ratio of samples, or of seconds, that the method used to those that the baseline used; its geometric
    mean counts. ``rate`` is how fast the baseline's error falls with it. ``key`` seeds the resampling.
    """
    errors, baseline, cost = (np.asarray(values, np.float64) for values in (errors, baseline, cost))
    seeds = len(errors)
    picks = np.random.default_rng([key, seeds]).integers(0, seeds, (RESAMPLES, seeds))

    def gain_of(pick: NDArray) -> Floats:
        ratio = (baseline[pick].mean(axis=-1) + TINY) / (errors[pick].mean(axis=-1) + TINY)
        return ratio / np.exp(rate * np.log(cost[pick]).mean(axis=-1))

    return Gain(float(gain_of(np.arange(seeds))), gain_of(picks), seeds)


def geometric_mean(gains: Sequence[Gain]) -> Interval:
    """Return the geometric mean of the gains on several scenes; its interval resamples seeds, but not scenes."""
    logarithms = np.mean([np.log(entry.resampled) for entry in gains], axis=0)
    value = float(np.exp(np.mean([np.log(entry.value) for entry in gains])))
    return percentiles(value, np.exp(logarithms), min(entry.seeds for entry in gains))


def percentiles(value: float, resampled: Floats, seeds: int) -> Interval:
    """Return the expanded percentile interval (Hesterberg 2015, section 5.3); its bounds are NaN for one seed.

    With few seeds plain percentiles are too narrow, as resamples spread less than Student's t: percentiles are taken
    further out by as much as a normal interval would have to be. Of 2000 intervals over log-normal errors 92 % then
    held the true ratio with five seeds, 73 % with three, 48 % with two, and 94 % with forty.
    """
    if seeds < 2 or np.ptp(resampled) == 0:
        return Interval(value, float("nan"), float("nan"))
    quantile = stats.t.ppf((1 - LEVEL) / 2, seeds - 1) * np.sqrt(seeds / (seeds - 1))
    outer = float(stats.norm.cdf(quantile))
    low, high = np.quantile(resampled, [outer, 1 - outer])
    return Interval(value, float(low), float(high))


def error_rate(seconds: Sequence[Sequence[float]], errors: Sequence[Sequence[float]]) -> float:
    """Return b of errors ~ seconds^-b, within SLOWEST and FASTEST: least squares on logarithms, a point per budget.

    ``seconds`` and ``errors`` hold a list of seeds per budget. Returns 1 for a single budget, or where errors vanish.
    """
    points = [(np.mean(np.log(time)), np.mean(error)) for time, error in zip(seconds, errors, strict=True)]
    if len(points) < 2 or min(error for _, error in points) <= 0 or np.ptp([time for time, _ in points]) == 0:
        return 1.0
    slope = np.polyfit([time for time, _ in points], np.log([error for _, error in points]), 1)[0]
    return float(np.clip(-slope, SLOWEST, FASTEST))
