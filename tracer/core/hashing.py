"""The integer hash behind keyed samples and IDs."""

from __future__ import annotations

from typing import Any

GOLDEN_RATIO = 0x9E3779B9
"""Odd multiplier that spreads consecutive integers over 32 bits (Knuth, TAOCP vol. 3, 6.4)."""


def mix(x: Any) -> Any:
    """Return a bijective avalanche hash of the mi.UInt32 ``x`` (C. Wellons, "lowbias32", 2018)."""
    x = x ^ (x >> 16)
    x = x * 0x7FEB352D
    x = x ^ (x >> 15)
    x = x * 0x846CA68B
    return x ^ (x >> 16)
