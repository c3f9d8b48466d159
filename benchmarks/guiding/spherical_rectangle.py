"""Points on a rectangle that are evenly spread over the directions in which it is seen, or over their cosines.

Source: Ureña, Fajardo and King 2013, "An area-preserving parametrization for spherical rectangles", eqs. 1-9. The warp
by cosines is linear between the corners, as in Hart et al. 2020, "Practical product sampling by fitting and composing
warps".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

LEAST_ANGLE = 1e-4
"""Solid angle in steradians below which float32 is too coarse, and places are drawn by area."""
LEAST_DEPTH = 1e-6
"""Distance of a point from the plane of a rectangle, as a share of its sides, below which that is so too."""
LEAST_COSINE = 0.01
"""Least cosine by which directions to the corners count, so that no place of the rectangle is left out."""


@dataclass
class SphericalRectangle:
    """Rectangles as seen from points, one for each lane."""

    seen_from: Any
    """mi.Point3f"""
    axes: tuple[Any, Any, Any]
    """mi.Vector3f: directions of the sides, and the one away from the point at right angles to both."""
    low: tuple[Any, Any]
    """mi.Float: first corner along the sides, from the foot of the point."""
    high: tuple[Any, Any]
    """mi.Float: opposite corner."""
    depth: Any
    """mi.Float: minus the distance of the point from the plane of the rectangle."""
    solid_angle: Any
    """mi.Float, in steradians."""
    offset: Any
    """mi.Float: k of the source."""
    edges: tuple[Any, Any]
    """mi.Float: b0 and b1 of the source."""

    @classmethod
    def of(cls, corner: Any, first: Any, second: Any, seen_from: Any) -> SphericalRectangle:
        """Return rectangles with a corner (mi.Point3f) and two sides at right angles (mi.Vector3f)."""
        lengths = dr.norm(first), dr.norm(second)
        x, y = first / lengths[0], second / lengths[1]
        z, towards = dr.cross(x, y), corner - seen_from
        side = dr.dot(towards, z)
        z, depth = dr.select(side > 0, -z, z), -dr.abs(side)
        x0, y0 = dr.dot(towards, x), dr.dot(towards, y)
        x1, y1 = x0 + lengths[0], y0 + lengths[1]
        n0, n1, n2, n3 = (part * dr.rsqrt(dr.square(depth) + dr.square(part)) for part in (-y0, x1, y1, -x0))
        angles = [dr.safe_acos(-a * b) for a, b in ((n0, n1), (n1, n2), (n2, n3), (n3, n0))]
        offset = dr.two_pi - angles[2] - angles[3]
        solid_angle = angles[0] + angles[1] - offset
        return cls(seen_from, (x, y, z), (x0, y0), (x1, y1), depth, solid_angle, offset, (n0, n2))

    @property
    def is_wide(self) -> Any:
        """mi.Bool: whether float32 is fine enough for these directions."""
        extent = self.high[0] - self.low[0] + self.high[1] - self.low[1]
        return (self.solid_angle > LEAST_ANGLE) & (self.depth < -LEAST_DEPTH * extent)

    def place(self, number: Any) -> Any:
        """Return the place (mi.Point3f) for a point of the unit square (mi.Point2f), evenly over solid angle."""
        sine, cosine = dr.sincos(number.x * self.solid_angle + self.offset)
        b0, b1 = self.edges
        slope = (cosine * b0 - b1) / sine
        cu = dr.clip(dr.mulsign(dr.rsqrt(dr.square(slope) + dr.square(b0)), slope), -1, 1)
        x = -cu * self.depth * dr.rsqrt(dr.maximum(1 - dr.square(cu), 1e-12))
        x = dr.clip(x, self.low[0], self.high[0])
        distance = dr.sqrt(dr.square(x) + dr.square(self.depth))
        low, high = (part * dr.rsqrt(dr.square(distance) + dr.square(part)) for part in (self.low[1], self.high[1]))
        height = dr.lerp(low, high, number.y)
        y = height * distance * dr.rsqrt(dr.maximum(1 - dr.square(height), 1e-12))
        y = dr.clip(y, self.low[1], self.high[1])
        return self.seen_from + x * self.axes[0] + y * self.axes[1] + self.depth * self.axes[2]

    def cosines(self, normal: Any) -> list[Any]:
        """Return the cosine (mi.Float) between a normal and the directions to four corners, none below the least.

        The corners are those at the numbers (0, 0), (1, 0), (0, 1) and (1, 1).
        """
        corners = [(x, y) for y in (self.low[1], self.high[1]) for x in (self.low[0], self.high[0])]
        towards = [x * self.axes[0] + y * self.axes[1] + self.depth * self.axes[2] for x, y in corners]
        return [dr.maximum(dr.dot(normal, dr.normalize(direction)), LEAST_COSINE) for direction in towards]


def warped(number: Any, corners: list[Any]) -> tuple[Any, Any]:
    """Return points of the unit square as dense as values that are linear between its corners, and their density.

    ``number``: mi.Point2f, evenly in the unit square; ``corners``: mi.Float at (0, 0), (1, 0), (0, 1) and (1, 1).
    """
    a, b, c, d = corners
    y = linear(number.y, a + b, c + d)
    low, high = dr.lerp(a, c, y), dr.lerp(b, d, y)
    x = linear(number.x, low, high)
    return mi.Point2f(x, y), 4 * dr.lerp(low, high, x) / (a + b + c + d)


def linear(number: Any, low: Any, high: Any) -> Any:
    """Return numbers in [0, 1) as dense as a line from ``low`` to ``high``, from evenly spread ones (mi.Float)."""
    root = dr.sqrt(dr.lerp(dr.square(low), dr.square(high), number))
    return dr.minimum(number * (low + high) / (low + root), 1.0 - 2.0**-24)
