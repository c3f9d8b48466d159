"""Sums over device arrays that are the same however many threads work.

An array is summed in blocks of BLOCK entries, each from its first to its last, and the blocks in order on the host.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.device import upload

BLOCK_BITS = 10
BLOCK = 1 << BLOCK_BITS
"""Number of entries that one thread sums: many blocks for many threads, few enough for the host."""


def sums(*arrays: Any) -> list[float]:
    """Return the sum of each device array, in double precision."""
    doubles = [mi.Float64(array) for array in arrays]
    dr.eval(doubles)
    return [float(block_sums(values).numpy().sum()) for values in doubles]


def block_sums(values: Any) -> Any:
    """Return the sum (mi.Float64) of each block of an mi.Float64."""
    return dr.block_reduce(dr.ReduceOp.Add, values, block_of(values), mode="evaluated")


def block_of(values: Any) -> int:
    """Return the number of entries in each block of an array."""
    return min(BLOCK, dr.width(values))


def largest(array: Any) -> float:
    """Return the largest entry of a device array, which has one at least."""
    return float(dr.block_reduce(dr.ReduceOp.Max, array, block_of(array), mode="evaluated").numpy().max())


def running_sum(values: Any) -> Any:
    """Return the sum (mi.Float64) of each entry of an mi.Float64 and all before it."""
    dr.eval(values)
    within = dr.block_prefix_reduce(dr.ReduceOp.Add, values, block_of(values), exclusive=False)
    before = np.cumsum(np.concatenate([[0.0], block_sums(values).numpy()[:-1]]))
    block = dr.arange(mi.UInt32, dr.width(values)) >> BLOCK_BITS
    return within + dr.gather(mi.Float64, upload(mi.Float64, before), block)
