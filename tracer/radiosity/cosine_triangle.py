"""Directions in spherical triangles, with a density in proportion to the cosine.

Seen from straight above, directions with the density of the cosine fill the unit disc evenly, and an arc of a great
circle is an arc of an ellipse around the middle. A triangle is cut at the azimuth of its middle corner; each of the
two parts lies between two such arcs and two azimuths. Newton's method finds the azimuth up to which a given area lies,
and the square of the radius is uniform between the arcs. (The cut is that of C. Peters, "BRDF importance sampling for
polygonal lights", ACM Trans. Graph. 40(4), 2021.)

A great circle lies in a plane with the normal m. At an azimuth that differs by psi from the azimuth of m, its arc has
the squared radius

    r^2 = k^2 / (k^2 + (1 - k^2) cos^2 psi),    k = |m_z|,

and the area between the arc and the middle is half of k atan(k tan psi).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.core.sphere import normalised
from tracer.radiosity.triangle_hierarchy import pyramid

COLUMNS = 8
"""Numbers stored for each part of a triangle, listed at ``parts_of``."""
STEPS = 5
"""Steps of Newton's method: they lead from the solution for a linear density to the limit of single precision."""


@dataclass(frozen=True)
class Arc:
    """Part of a great circle above the plane, seen from straight above: an arc of an ellipse."""

    tilt: float
    """The k of the formula: absolute value of the z coordinate of the normal of the circle's plane, 0 to 1."""
    azimuth: float
    """Azimuth in radians at which psi is 0."""

    def area(self, azimuth: float) -> float:
        """Return the area between the arc and the middle of the disc, from psi = 0 on."""
        psi = azimuth - self.azimuth
        return 0.5 * self.tilt * float(np.arctan2(self.tilt * np.sin(psi), np.cos(psi)))


def parts_of(corners: Floats) -> Floats:
    """Return the two parts (T, 2, 8) of spherical triangles (T, 3, 3) above the plane z = 0.

    The columns are: the azimuth where the part begins and its extent; k and azimuth of the inner arc; k and azimuth of
    the outer arc; the area; the share of the triangle's area that lies before the part. The zenith may be a corner of a
    triangle, but never within it.
    """
    return np.array([cut_triangle(triangle) for triangle in corners])


def cut_triangle(corners: Floats) -> list[list[float]]:
    """Return the two parts (2, 8) of one triangle (3, 3); the second is empty where the zenith is a corner."""
    is_zenith = np.hypot(corners[:, 0], corners[:, 1]) < 1e-9
    azimuths = np.arctan2(corners[:, 1], corners[:, 0])
    inside = float(np.arctan2(*corners[~is_zenith, :2].sum(axis=0)[::-1]))
    # Azimuths are counted from the middle of the triangle, so that no triangle lies across the step from pi to -pi.
    azimuths = inside + (azimuths - inside + np.pi) % (2 * np.pi) - np.pi
    if is_zenith.any():
        first, last = np.flatnonzero(~is_zenith)[np.argsort(azimuths[~is_zenith])]
        arcs = [(azimuths[first], azimuths[last], Arc(0.0, inside), arc(corners[first], corners[last], inside))]
    else:
        first, middle, last = np.argsort(azimuths)
        arcs = []
        for left, right in ((first, middle), (middle, last)):
            whole, half = arc(corners[first], corners[last], inside), arc(corners[left], corners[right], inside)
            between = 0.5 * (azimuths[left] + azimuths[right])
            inner, outer = sorted((whole, half), key=lambda candidate: squared_radius(candidate, between))
            arcs.append((azimuths[left], azimuths[right], inner, outer))
    areas = [
        outer.area(end) - outer.area(begin) - inner.area(end) + inner.area(begin) for begin, end, inner, outer in arcs
    ]
    rows = [
        [begin, end - begin, inner.tilt, inner.azimuth, outer.tilt, outer.azimuth, area, before]
        for (begin, end, inner, outer), area, before in zip(arcs, areas, np.cumsum([0.0, *areas]), strict=False)
    ]
    rows = [[*row[:7], row[7] / sum(areas)] for row in rows]
    return rows if len(rows) == 2 else [*rows, [*rows[0][:6], 0.0, 2.0]]


def arc(first: Floats, second: Floats, inside: float) -> Arc:
    """Return the arc between two directions; its psi is 0 within a quarter turn of the azimuth ``inside``."""
    normal = normalised(np.cross(first, second))
    azimuth = float(np.arctan2(normal[1], normal[0])) if np.hypot(normal[0], normal[1]) > 1e-9 else inside
    if np.cos(inside - azimuth) < 0:
        azimuth += np.pi
    return Arc(abs(float(normal[2])), azimuth)


def squared_radius(ellipse: Arc, azimuth: float) -> float:
    """Return r^2 of an arc at an azimuth."""
    square = ellipse.tilt**2
    return square / (square + (1 - square) * float(np.cos(azimuth - ellipse.azimuth)) ** 2) if square else 0.0


@cache
def parts_of_pyramid(depth: int) -> Floats:
    """Return the parts (N, 2, 8) of all triangles of a pyramid, see ``parts_of``."""
    return parts_of(pyramid(depth).corners)


def table_of(depth: int) -> Any:
    """Return the parts of all triangles of a pyramid as one mi.Float, for ``cosine_in_triangle``."""
    return upload(mi.Float, parts_of_pyramid(depth))


def cosine_in_triangle(table: Any, triangle: Any, u: Any, v: Any) -> Any:
    """Return directions (mi.Vector3f) in triangles (mi.UInt32, by number) from uniform numbers u and v in [0, 1).

    Their density is the cosine of the angle to z, divided by the projected solid angle of the triangle.
    """
    split = dr.gather(mi.Float, table, 2 * COLUMNS * triangle + (2 * COLUMNS - 1))
    is_second = u >= split
    row = COLUMNS * (2 * triangle + dr.select(is_second, mi.UInt32(1), mi.UInt32(0)))
    begin, extent, k1, azimuth1, k2, azimuth2, area = (dr.gather(mi.Float, table, row + k) for k in range(COLUMNS - 1))
    # The interval of u that selects a part is stretched to [0, 1).
    u = dr.select(is_second, (u - split) / (1 - split), u / dr.minimum(split, 1))
    psi1, psi2 = begin - azimuth1, begin - azimuth2
    start_area = area_of(k2, psi2) - area_of(k1, psi1)
    at_begin, at_end = width(k1, psi1, k2, psi2), width(k1, psi1 + extent, k2, psi2 + extent)
    t = u * (at_begin + at_end) / (at_begin + dr.safe_sqrt(dr.lerp(dr.square(at_begin), dr.square(at_end), u)) + 1e-20)
    for _ in range(STEPS):
        azimuth = t * extent
        missing = u * area - (area_of(k2, psi2 + azimuth) - area_of(k1, psi1 + azimuth) - start_area)
        slope = 0.5 * width(k1, psi1 + azimuth, k2, psi2 + azimuth) * extent
        t = dr.clip(t + missing / dr.maximum(slope, 1e-9), 0, 1)
    azimuth = t * extent
    inner, outer = squared(k1, psi1 + azimuth), squared(k2, psi2 + azimuth)
    radius_squared = dr.lerp(inner, outer, v)
    sine, cosine = dr.sincos(begin + azimuth)
    radius = dr.safe_sqrt(radius_squared)
    return mi.Vector3f(radius * cosine, radius * sine, dr.safe_sqrt(1 - radius_squared))


def area_of(k: Any, psi: Any) -> Any:
    """Return the area between an arc and the middle of the disc, from psi = 0 on, on the device."""
    sine, cosine = dr.sincos(psi)
    return 0.5 * k * dr.atan2(k * sine, cosine)


def squared(k: Any, psi: Any) -> Any:
    """Return r^2 of an arc at psi, on the device."""
    square = dr.square(k)
    return square / dr.maximum(square + (1 - square) * dr.square(dr.cos(psi)), 1e-20)


def width(k1: Any, psi1: Any, k2: Any, psi2: Any) -> Any:
    """Return the difference of r^2 of two arcs: the density of the azimuth, times 2."""
    return dr.maximum(squared(k2, psi2) - squared(k1, psi1), 0)
