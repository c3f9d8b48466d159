"""Directions in spherical triangles, all with the same density (J. Arvo, "Stratified sampling of spherical triangles",
SIGGRAPH 1995).
"""

from __future__ import annotations

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.core.sphere import normalised, solid_angle
from tracer.radiosity.triangle_hierarchy import pyramid

COLUMNS = 12
"""Numbers stored for each triangle: corners A, B and C; the angle at A; the cosine of the edge AB; the area."""


@cache
def columns_of_pyramid(depth: int) -> Floats:
    """Return the columns (N, 12) of all triangles of a pyramid, see ``COLUMNS``."""
    corners = pyramid(depth).corners
    a, b, c = corners.transpose(1, 0, 2)
    to_b, to_c = normalised(np.cross(a, b)), normalised(np.cross(a, c))
    angle = np.arccos(np.clip(np.sum(to_b * to_c, axis=1), -1, 1))
    rest = np.stack([angle, np.sum(a * b, axis=1), solid_angle(a, b, c)], axis=1)
    return np.concatenate([corners.reshape(len(corners), 9), rest], axis=1)


def uniform_table_of(depth: int) -> Any:
    """Return the columns of all triangles of a pyramid as one mi.Float, for ``uniform_in_triangle``."""
    return upload(mi.Float, columns_of_pyramid(depth))


def uniform_in_triangle(table: Any, triangle: Any, u: Any, v: Any, active: Any = True) -> Any:
    """Return directions (mi.Vector3f) in triangles (mi.UInt32, by number) from uniform numbers u and v in [0, 1)."""

    def column(k: int) -> Any:
        return dr.gather(mi.Float, table, COLUMNS * triangle + k, active)

    a, b, c = (mi.Vector3f(column(k), column(k + 1), column(k + 2)) for k in (0, 3, 6))
    angle, edge, area = column(9), column(10), column(11)
    # The triangle A B C' with the area u times that of A B C; C' lies on the edge AC.
    sine, cosine = dr.sincos(u * area - angle)
    sin_angle, cos_angle = dr.sincos(angle)
    p, q = cosine - cos_angle, sine + sin_angle * edge
    reach = ((q * cosine - p * sine) * cos_angle - q) / ((q * sine + p * cosine) * sin_angle)
    reach = dr.select(dr.isfinite(reach), dr.clip(reach, -1, 1), 1)
    new_c = reach * a + dr.safe_sqrt(1 - dr.square(reach)) * across(c, a)
    height = 1 - v * (1 - dr.dot(new_c, b))
    return dr.normalize(height * b + dr.safe_sqrt(1 - dr.square(height)) * across(new_c, b))


def across(vector: Any, axis: Any) -> Any:
    """Return the part of a vector (mi.Vector3f) across a unit axis, scaled to length 1; 0 if there is none."""
    rest = vector - dr.dot(vector, axis) * axis
    length = dr.norm(rest)
    return dr.select(length > 1e-7, rest / length, 0)
