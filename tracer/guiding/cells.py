"""Cells of space and direction: a grid of boxes, times the six faces of a cube by which way a surface looks.

What a light gives to a point depends mostly on where the point is and which way its surface looks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats

FACES = 6
"""Ways a surface may look: along the positive or negative x, y or z axis, whichever is nearest to its normal."""


@dataclass(frozen=True)
class Grid:
    """A grid of boxes of space with equal edges. What lies outside belongs to the nearest box."""

    low: Floats
    """(3,): corner with the smallest coordinates."""
    edge: float
    """Length of the edges of a box, in units of the scene."""
    boxes: tuple[int, int, int]
    """Number of boxes along each axis."""

    @property
    def cell_count(self) -> int:
        """Number of boxes, times that of faces."""
        return int(np.prod(self.boxes)) * FACES

    @classmethod
    def around(cls, points: Floats, box_count: int) -> Grid:
        """Return a grid of about ``box_count`` boxes around most of ``points`` (N, 3): a few far away do not count."""
        low, high = np.quantile(points, (0.005, 0.995), axis=0)
        extent = np.maximum(high - low, 1e-6 * max(float((high - low).max()), 1e-30))
        edge = float(np.prod(extent) / box_count) ** (1 / 3)
        for _ in range(3):  # an axis that is shorter than a box has one; the others share the boxes
            long = extent > edge
            edge = float(np.prod(extent[long]) / box_count) ** (1 / max(int(long.sum()), 1)) if long.any() else edge
        edge = max(edge, float(extent.max()) / box_count)
        boxes = np.clip(np.ceil(extent / edge), 1, box_count).astype(int)
        return cls(low, edge, (int(boxes[0]), int(boxes[1]), int(boxes[2])))

    def cells(self, points: Floats, normals: Floats) -> np.ndarray:
        """Return the cell (N,) of each point (N, 3) on a surface with a normal (N, 3), as ``CellFinder`` does."""
        place = np.clip((points - self.low) / self.edge, 0, np.array(self.boxes) - 1).astype(np.int64)
        axis = np.argmax(np.abs(normals), axis=-1)
        face = 2 * axis + (np.take_along_axis(normals, axis[:, None], -1)[:, 0] > 0)
        columns, rows, _ = self.boxes
        return ((place[:, 2] * rows + place[:, 1]) * columns + place[:, 0]) * FACES + face

    def parents(self, factor: int) -> np.ndarray:
        """Return, for each cell (cells,), the number of the cell in a grid whose boxes are ``factor`` times as long."""
        columns, rows, layers = self.boxes
        z, y, x, face = np.indices((layers, rows, columns, FACES)).reshape(4, -1)
        wide, high = -(-columns // factor), -(-rows // factor)
        return ((z // factor * high + y // factor) * wide + x // factor) * FACES + face


@dataclass
class CellFinder:
    """A grid on the device."""

    low: Any
    """mi.Point3f: corner with the smallest coordinates."""
    scale: Any
    """mi.Float: boxes per unit of length."""
    boxes: Any
    """mi.Vector3u: number of boxes along each axis."""

    @classmethod
    def of(cls, grid: Grid) -> CellFinder:
        """Put a grid on the device; no number becomes part of a kernel's code."""
        low = mi.Point3f(*(dr.opaque(mi.Float, float(value)) for value in grid.low))
        boxes = mi.Vector3u(*(dr.opaque(mi.UInt32, count) for count in grid.boxes))
        return cls(low, dr.opaque(mi.Float, 1 / grid.edge), boxes)

    def cell(self, position: Any, normal: Any) -> Any:
        """Return the cell (mi.UInt32) of points (mi.Point3f) on surfaces with a normal (mi.Vector3f)."""
        last = mi.Vector3f(self.boxes) - 1.0
        inside = dr.clip((position - self.low) * self.scale, 0.0, last)
        place = mi.Vector3u(mi.Vector3i(dr.select(dr.isfinite(inside), inside, 0.0)))
        return ((place.z * self.boxes.y + place.y) * self.boxes.x + place.x) * FACES + face_of(normal)


def face_of(normal: Any) -> Any:
    """Return the face (mi.UInt32, 0 to 5) of the cube around a surface through which its normal (mi.Vector3f) goes."""
    size = dr.abs(normal)
    is_x, is_y = (size.x >= size.y) & (size.x >= size.z), size.y >= size.z
    axis = dr.select(is_x, mi.UInt32(0), dr.select(is_y, mi.UInt32(1), mi.UInt32(2)))
    along = dr.select(is_x, normal.x, dr.select(is_y, normal.y, normal.z))
    return 2 * axis + dr.select(along > 0, mi.UInt32(1), mi.UInt32(0))
