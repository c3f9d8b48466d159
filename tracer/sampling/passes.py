"""How the samples of a round are cut into passes: large enough to fill the device, small enough to show progress."""

from __future__ import annotations

from math import ceil

PASS_SIZES = (1 << 20, 1 << 21, 1 << 22)
"""Samples per pass: enough to keep the threads busy, few enough for flat memory and a sign of life every second."""


PASS_SECONDS = 1.5
"""A pass takes no longer, unless the smallest does."""


def even_pass(left: int, size: int, largest: int = PASS_SIZES[-1]) -> int:
    """Return the samples of the next pass of ``left``, so that passes are about as long as ``size`` and each other.

    None has more than ``largest``.
    """
    return ceil(left / max(round(left / size), ceil(left / largest)))


def next_pass_size(rate: float) -> int:
    """Return the samples of the next pass: the most of PASS_SIZES that take no more than PASS_SECONDS."""
    return max((each for each in PASS_SIZES if each <= rate * PASS_SECONDS), default=PASS_SIZES[0])
