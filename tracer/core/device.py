"""From NumPy to the device.

On a processor Dr.Jit takes the memory of a NumPy array for its own and reads it in packets: up to 15 entries beyond the
last, which now and then is memory that the process does not have. And it compiles kernels anew for each alignment of
what they read. So arrays are copied to where there is room behind them, at an address as Dr.Jit chooses its own.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import ArrayLike, NDArray

ALIGNMENT = 64
ROOM = 16 * 8
"""Bytes behind an array: a packet of the widest entries."""
KINDS = {
    dr.VarType.Bool: np.bool_,
    dr.VarType.Int32: np.int32,
    dr.VarType.UInt32: np.uint32,
    dr.VarType.Int64: np.int64,
    dr.VarType.UInt64: np.uint64,
    dr.VarType.Float32: np.float32,
    dr.VarType.Float64: np.float64,
}


def upload(kind: Any, array: ArrayLike) -> Any:
    """Return an array of any shape and numbers, row by row, as a device array of a kind, such as mi.Float."""
    return kind(with_room(np.asarray(array, numpy_kind(kind))))


def numpy_kind(kind: Any) -> Any:
    """Return the NumPy type of the entries of a device array, or of a kind of them."""
    return KINDS[dr.type_v(kind)]


def upload_tensor(array: ArrayLike) -> Any:
    """Return an array of numbers as a mi.TensorXf of its shape."""
    return mi.TensorXf(upload(mi.Float, array), np.shape(array))


def with_room(array: NDArray) -> NDArray:
    """Return a flat copy of an array that is aligned, with ROOM behind it."""
    memory = np.empty(ALIGNMENT + array.nbytes + ROOM, np.uint8)
    begin = -memory.ctypes.data % ALIGNMENT
    found = memory[begin : begin + array.nbytes].view(array.dtype)
    found.reshape(array.shape)[...] = array
    return found
