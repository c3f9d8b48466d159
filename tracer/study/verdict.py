"""What the measurements of a scene mean for who renders it: one sentence."""

from __future__ import annotations

import math

from tracer.study.gains import Interval
from tracer.study.records import Row

UNIFORM = "uniform"
"""Name of the method that others are compared with."""
NO_DIFFERENCE = 0.005
"""Largest distance of a gain from 1 for which two methods are said to draw the same."""


def best(rows: list[Row]) -> Row | None:
    """Return the row of the criterion that gains most in the same time; None if there is none with a gain.

    ``rows``: those of one scene and budget, of methods that draw by a criterion.
    """
    measured = [row for row in rows if row.method != UNIFORM and row.gain_time is not None]
    return max(measured, key=lambda row: row.gain_time.mean if row.gain_time else 0.0, default=None)


def pays(row: Row) -> bool:
    """Return whether a method is not worse than uniform sampling in the same time, as far as was measured."""
    return row.gain_time is None or ends(row.gain_time)[1] >= 1


def in_words(row: Row, error: str) -> str:
    """Return what a method gains over uniform sampling on a scene, as a clause; ``error``: name of what is compared.

    Whether a gain is certain is judged by its 95 % interval over seeds.
    """
    assert row.gain_samples is not None
    assert row.gain_time is not None
    if abs(row.gain_samples.mean - 1) < NO_DIFFERENCE:  # times that differ then are those of the machine
        return (
            f"On {row.scene} at {row.budget}, {row.method} gains nothing over uniform sampling: with as many samples "
            f"it has the same {error}"
        )
    low, high = ends(row.gain_time)
    doubt = ""
    if row.seeds == 1:
        doubt = ", as far as a single seed can tell"
    elif low < 1 < high:
        doubt = f", which {row.seeds} seeds cannot tell from none"
    return (
        f"Against uniform sampling on {row.scene} at {row.budget}, {row.method} has "
        f"{less(row.gain_samples.mean)} {error} with as many samples, and {less(row.gain_time.mean)} in the same time"
        f"{doubt}"
    )


def ends(interval: Interval) -> tuple[float, float]:
    """Return the ends of an interval, or the value twice if there is no interval."""
    return (interval.mean, interval.mean) if math.isnan(interval.low) else (interval.low, interval.high)


def less(gain: float) -> str:
    """Return a gain in words: the factor by which an error is divided."""
    if abs(gain - 1) < NO_DIFFERENCE:
        return "as much"
    return f"{gain:.2f} times less" if gain > 1 else f"{1 / gain:.2f} times more"
