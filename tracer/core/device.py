"""Copy NumPy arrays to the device and back, and small computations on the device.

On a processor Dr.Jit uses the memory of a NumPy array as its own and reads it in packets: up to 15 entries beyond the
last, which now and then is memory that the process does not have. It also compiles a kernel anew for each alignment of
the arrays that the kernel reads. So arrays are copied to memory with room behind it, aligned as Dr.Jit aligns its own:
large ones to memory that Dr.Jit keeps for such purposes, as the pages of new memory take ten times as long.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.core import parallel
from tracer.core.arrays import Floats, Singles

ALIGNMENT = 64
"""Every array that is uploaded begins at an address that is a multiple of this many bytes, as Dr.Jit's own do."""
ROOM = 16 * 8
"""Bytes that are kept free behind an uploaded array: a packet of 16 entries of the widest type, 8 bytes each."""
LARGE = 1 << 20
"""Bytes from which on an array is copied to memory of Dr.Jit, which waits for the device."""
KINDS = {
    dr.VarType.Bool: np.bool_,
    dr.VarType.Int32: np.int32,
    dr.VarType.UInt32: np.uint32,
    dr.VarType.Int64: np.int64,
    dr.VarType.UInt64: np.uint64,
    dr.VarType.Float32: np.float32,
    dr.VarType.Float64: np.float64,
}
"""NumPy type of the entries of a device array, by Dr.Jit's type of them."""


def upload(kind: Any, array: ArrayLike) -> Any:
    """Return numbers of any shape, row by row, as a device array of type ``kind``, such as mi.Float."""
    numbers = np.asarray(array)
    if dr.backend_v(kind) != dr.JitBackend.LLVM or numbers.size * numpy_kind(kind)().itemsize < LARGE:
        return kind(with_room(np.asarray(numbers, numpy_kind(kind))))
    target = dr.empty(kind, numbers.size)
    parallel.copy(target.numpy().reshape(numbers.shape), numbers)
    return target


def numpy_kind(kind: Any) -> Any:
    """Return the NumPy type of the entries of a device array, or of a type of device arrays such as mi.Float."""
    return KINDS[dr.type_v(kind)]


def upload_tensor(array: ArrayLike) -> Any:
    """Return an array of numbers as an mi.TensorXf of the same shape."""
    return mi.TensorXf(upload(mi.Float, array), np.shape(array))


def to_host(array: Any, shape: tuple[int, ...]) -> NDArray:
    """Return a copy of a device array as NumPy, in ``shape``, row by row.

    Memory that belongs to Dr.Jit must not leave this function. If another thread frees it, as Dask's thread does on a
    worker, that thread waits for Dr.Jit's lock while it holds Python's, and the thread that draws may hold Dr.Jit's
    lock and wait for Python's.
    """
    values = array.numpy().reshape(shape)
    return parallel.copy(np.empty(values.shape, values.dtype), values)


def channels_of(values: Singles, count: int) -> list[Any]:
    """Return the first ``count`` channels of ``values`` (H, W, C), each an mi.Float, row by row."""
    on_device, stride = upload(mi.Float, values), dr.opaque(mi.UInt32, values.shape[-1])
    first = dr.arange(mi.UInt32, values.shape[0] * values.shape[1]) * stride
    return [dr.gather(mi.Float, on_device, first + k) for k in range(count)]


def interleave(target: Any, channels: Sequence[Any], pixel: Any, active: Any = True) -> None:
    """Write the values of pixels into ``target`` (mi.Float), which has all channels of pixel 0, then of pixel 1, ...

    ``channels``: for each, an array with one value for each pixel; ``pixel`` (mi.UInt32): no two may be the same;
    ``active``: which of them are written. ``target`` is written when it is evaluated, so that several writes may be one
    kernel.
    """
    first = pixel * len(channels)
    for k, channel in enumerate(channels):
        dr.scatter(target, mi.Float(channel), first + k, active, mode=dr.ReduceMode.Permute)


def with_room(array: NDArray) -> NDArray:
    """Return a flat copy of an array that begins at a multiple of ALIGNMENT bytes and has ROOM bytes behind it."""
    memory = np.empty(ALIGNMENT + array.nbytes + ROOM, np.uint8)
    begin = -memory.ctypes.data % ALIGNMENT
    copy = memory[begin : begin + array.nbytes].view(array.dtype)
    copy.reshape(array.shape)[...] = array
    return copy


def divide(number: Any, divisor: int) -> tuple[Any, Any]:
    """Return quotient and remainder of an mi.UInt32 by ``divisor``, which does not become part of the kernel's code."""
    opaque = dr.opaque(mi.UInt32, divisor)
    quotient = number // opaque
    return quotient, number - quotient * opaque


def to_unit(bits: Any) -> Any:
    """Return random bits (mi.UInt32) as numbers in [0, 1) (mi.Float)."""
    return mi.Float(bits >> 8) * (1.0 / (1 << 24))


def gather_rows(rows: Floats, index: Any) -> Any:
    """Return the rows (N, 3) that ``index`` (mi.UInt32) names, as mi.Vector3f."""
    table = upload(mi.Float, rows)
    return mi.Vector3f(*(dr.gather(mi.Float, table, 3 * index + k) for k in range(3)))


def seed_number(seed: Any) -> int:
    """Return a seed as ``mi.render`` hands it to integrators, an int or an mi.UInt32, as an int."""
    return int(seed[0]) if isinstance(seed, mi.UInt32) else int(seed)


def number_of_shape(shape: Any) -> int:
    """Return the number, from 1, that stands for a shape of Mitsuba in kernels."""
    return int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))[0])


def table_by_shape(shapes: Sequence[Any], values: ArrayLike) -> Any:
    """Return a table (mi.UInt32) of the shapes' ``values``, each at its shape's number; 0 where there is no shape."""
    numbers = [number_of_shape(shape) for shape in shapes]
    table = np.zeros(max(numbers, default=0) + 1, np.uint32)
    table[numbers] = values
    return upload(mi.UInt32, table)


def numbers_hit(intersection: Any) -> tuple[Any, Any]:
    """Return the numbers (mi.UInt32) of the instance and the shape that rays hit, 0 for none.

    ``intersection``: from ``ray_intersect`` or ``ray_intersect_preliminary`` of a scene.
    """
    return dr.reinterpret_array(mi.UInt32, intersection.instance), dr.reinterpret_array(mi.UInt32, intersection.shape)


def multiplicity(ids: Any, group: int) -> Any:
    """Return for each ID (mi.UInt32) how many IDs of its group are equal to it, itself included.

    Each ``group`` consecutive IDs form one group.
    """
    start = divide(dr.arange(mi.UInt32, dr.width(ids)), group)[0] * dr.opaque(mi.UInt32, group)
    end = start + dr.opaque(mi.UInt32, group)

    def step(position: Any, equal: Any) -> tuple[Any, Any]:
        is_equal = dr.gather(mi.UInt32, ids, position) == ids
        return position + 1, equal + dr.select(is_equal, mi.UInt32(1), mi.UInt32(0))

    _, equal = dr.while_loop((start, dr.zeros(mi.UInt32, dr.width(ids))), lambda position, _: position < end, step)
    return equal
