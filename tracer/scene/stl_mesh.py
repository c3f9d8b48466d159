"""Read binary STL files: triangles that each have corners of their own, which are joined where they are equal."""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Integers, Singles

HEADER = 84
"""Bytes before the triangles; the last four are their number."""
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("flags", "<u2")])
"""How a triangle stands in the file."""
FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
"""Odd numbers without a pattern, which spread the bits of the three coordinates over 64."""


def read_stl(data: bytes) -> tuple[Singles, Integers] | None:
    """Return the different vertices (N, 3) and the triangles (F, 3) of a binary STL file; None if it is none."""
    count = int(np.frombuffer(data, "<u4", 1, HEADER - 4)[0]) if len(data) >= HEADER else 0
    if not count or len(data) != HEADER + count * TRIANGLE.itemsize:
        return None
    places, number = joined(np.frombuffer(data, TRIANGLE, count, HEADER)["corners"].reshape(-1, 3))
    return places, number.reshape(-1, 3)


def joined(points: Singles) -> tuple[Singles, Integers]:
    """Return the different points (N, 3), and which of them each point (K,) is.

    Points are sorted by a number of 64 bits that is made of their coordinates. Different points practically never have
    equal numbers; where they do, all coordinates are sorted instead, which takes longer.
    """
    points = np.asarray(points + np.float32(0), np.float32)  # there are two zeros, which are one place
    bits = np.ascontiguousarray(points).view(np.uint32)
    keys = np.zeros(len(points), np.uint64)
    for axis in range(3):
        keys = (keys ^ (keys >> np.uint64(29)) ^ bits[:, axis]) * FACTORS[axis]
    _, first, number = np.unique(keys, return_index=True, return_inverse=True)
    places = points[first]
    if np.array_equal(places[number], points, equal_nan=True):
        return places, number
    places, number = np.unique(points, axis=0, return_inverse=True)
    return places, number.reshape(-1)
