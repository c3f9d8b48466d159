"""Sizes of the passes into which a round is cut: large enough to occupy the device, small enough to show progress."""

from __future__ import annotations

from math import ceil

PASS_SIZES = (1 << 20, 1 << 21, 1 << 22)
"""Numbers of samples that a pass may have: enough to keep all threads busy, few enough that memory stays the same for
large pictures and that progress shows every second."""


PASS_SECONDS = 1.5
"""Most seconds that a pass takes, unless a pass of the smallest size takes longer."""


MANY_OBJECTS = 1 << 12
"""Number of shapes and lights beyond which passes are as large as may be: to begin a pass takes 40 microseconds for
each of them."""


def even_pass(left: int, size: int, largest: int = PASS_SIZES[-1]) -> int:
    """Return the samples of the next pass where ``left`` samples are left, so that all passes are about equal.

    They have about ``size`` samples each, and none has more than ``largest``.
    """
    return ceil(left / max(round(left / size), ceil(left / largest)))


def next_pass_size(rate: float | None, object_count: int) -> int:
    """Return the samples of the next pass: the largest of PASS_SIZES that takes at most PASS_SECONDS.

    ``rate``: samples per second; None: not known yet. ``object_count``: number of shapes and lights of the scene; with
    many of them it is the largest pass.
    """
    if object_count >= MANY_OBJECTS:
        return PASS_SIZES[-1]
    if rate is None:
        return PASS_SIZES[1]
    return max((size for size in PASS_SIZES if size <= rate * PASS_SECONDS), default=PASS_SIZES[0])
