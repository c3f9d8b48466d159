"""Numbers as a person reads them."""

from __future__ import annotations

from math import floor

PREFIXES = ((1e15, " P"), (1e12, " T"), (1e9, " G"), (1e6, " M"), (1e3, " k"))
"""Factors and their SI prefixes, the largest first."""


def with_prefix(count: float) -> str:
    """Return a count >= 0 with three digits and an SI prefix, such as "6.14 k"; below a thousand the whole number."""
    for factor, prefix in PREFIXES:
        if count >= 0.9995 * factor:
            return f"{count / factor:#.3g}".rstrip(".") + prefix
    return f"{count:.0f}"


def percent(share: float, digits: int) -> str:
    """Return a share from 0 to 1 in percent, with ``digits`` digits after the point, rounded down.

    Rounded up, a goal that is nearly reached would look as if it were reached.
    """
    scale = 10**digits
    return f"{floor(100 * share * scale + 1e-6) / scale:.{digits}f}"


def mean_count(mean: float) -> str:
    """Return a mean number of samples >= 0 with three digits, or from 100 on with one decimal; without exponents."""
    return f"{mean:.3g}" if mean < 99.95 else f"{mean:.1f}".removesuffix(".0")


def samples_in_words(mean: float) -> str:
    """Return a mean number of samples >= 0 per pixel in words."""
    count = mean_count(mean)
    return f"{count} {'sample' if count == '1' else 'samples'} per pixel"
