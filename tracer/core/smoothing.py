"""Means over the neighbours of each pixel, on the device.

A picture is a flat array, row by row. It is smoothed along its rows, then along its columns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.device import divide

Kernel = Sequence[float]
"""Weights, which sum to 1, of a pixel and its neighbours to both sides; an odd number of them."""
Beyond = Literal["nearest", "mirror"]
"""Which pixel stands for one beyond the edge, as in ``scipy.ndimage``: that at the edge, or its mirror image about the
centre of the pixel at the edge. Kernels that reach beyond its second mirror image see the edge."""


def box(width: int) -> Kernel:
    """Return the kernel of the mean over ``width`` pixels, an odd number."""
    return [1.0 / width] * width


def gaussian(deviation: float) -> Kernel:
    """Return the kernel of a Gaussian, cut off at 4 deviations; ``deviation`` in pixels."""
    reach = int(4 * deviation + 0.5)
    values = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation) ** 2)
    return (values / values.sum()).tolist()


def smoothed(values: Any, size: tuple[int, int], *kernels: Kernel, beyond: Beyond = "nearest") -> list[Any]:
    """Return ``values`` (mi.Float), a picture of ``size`` (height, width), smoothed by each kernel in both directions.

    The results are evaluated.
    """
    row, column = (mi.Int32(index) for index in divide(dr.arange(mi.UInt32, size[0] * size[1]), size[1]))
    height, width = (dr.opaque(mi.Int32, side) for side in size)
    dr.eval(values)
    along_rows = weighted([values] * len(kernels), kernels, lambda k: row * width + within(column + k, width, beyond))
    dr.eval(along_rows)
    along_columns = weighted(along_rows, kernels, lambda k: within(row + k, height, beyond) * width + column)
    dr.eval(along_columns)
    return along_columns


def weighted(arrays: Sequence[Any], kernels: Sequence[Kernel], index: Callable[[int], Any]) -> list[Any]:
    """Return for each array and its kernel the weighted sum over neighbours; ``index``: of the neighbour at k."""
    totals = [mi.Float(0) for _ in kernels]
    reach = max(len(kernel) // 2 for kernel in kernels)
    for k in range(-reach, reach + 1):
        neighbour = mi.UInt32(index(k))
        for j, (array, kernel) in enumerate(zip(arrays, kernels, strict=True)):
            if abs(k) <= len(kernel) // 2:
                totals[j] = dr.fma(dr.gather(mi.Float, array, neighbour), kernel[k + len(kernel) // 2], totals[j])
    return totals


def within(index: Any, count: Any, beyond: Beyond) -> Any:
    """Return the index (mi.Int32) of the pixel, of ``count`` in a line, that stands for one at ``index``."""
    last = count - 1
    if beyond == "nearest":
        return dr.clip(index, 0, last)
    return dr.clip(last - dr.abs(last - dr.abs(index)), 0, last)
