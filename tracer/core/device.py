"""From NumPy to the device.

On a processor Dr.Jit takes the memory of a NumPy array for its own and reads it in packets: up to 15 entries beyond the
last, which now and then is memory that the process does not have. And it compiles kernels anew for each alignment of
what they read. So arrays are copied to where there is room behind them, at an address as Dr.Jit chooses its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.core.arrays import Floats

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


def divide(number: Any, divisor: int) -> tuple[Any, Any]:
    """Return quotient and remainder of a mi.UInt32 by a number that is not compiled into the kernel."""
    opaque = dr.opaque(mi.UInt32, divisor)
    quotient = number // opaque
    return quotient, number - quotient * opaque


def to_unit(bits: Any) -> Any:
    """Return mi.UInt32 as mi.Float in [0, 1)."""
    return mi.Float(bits >> 8) * (1.0 / (1 << 24))


def gather_rows(rows: Floats, index: Any) -> Any:
    """Return the rows (N, 3) that ``index`` (mi.UInt32) names, as mi.Vector3f."""
    table = upload(mi.Float, rows)
    return mi.Vector3f(*(dr.gather(mi.Float, table, 3 * index + k) for k in range(3)))


def number_of_shape(shape: Any) -> int:
    """Return the number, from 1, by which kernels know a shape of Mitsuba."""
    return int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))[0])


def table_by_shape(shapes: Sequence[Any], values: ArrayLike) -> Any:
    """Return mi.UInt32 that hold the value of each shape at the number of it, 0 where there is no shape."""
    numbers = [number_of_shape(shape) for shape in shapes]
    table = np.zeros(max(numbers, default=0) + 1, np.uint32)
    table[numbers] = values
    return upload(mi.UInt32, table)


def numbers_hit(found: Any) -> tuple[Any, Any]:
    """Return the numbers (mi.UInt32) of the instance and the shape that were hit, 0 for none."""
    return dr.reinterpret_array(mi.UInt32, found.instance), dr.reinterpret_array(mi.UInt32, found.shape)


def multiplicity(ids: Any, group: int) -> Any:
    """Return for each ID (mi.UInt32) how many of the ``group`` consecutive IDs it belongs to are equal to it."""
    start = divide(dr.arange(mi.UInt32, dr.width(ids)), group)[0] * dr.opaque(mi.UInt32, group)
    end = start + dr.opaque(mi.UInt32, group)

    def step(other: Any, equal: Any) -> tuple[Any, Any]:
        same = dr.gather(mi.UInt32, ids, other) == ids
        return other + 1, equal + dr.select(same, mi.UInt32(1), mi.UInt32(0))

    _, equal = dr.while_loop((start, dr.zeros(mi.UInt32, dr.width(ids))), lambda other, _: other < end, step)
    return equal
