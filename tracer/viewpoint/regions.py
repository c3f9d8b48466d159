"""Complexity of regions of what is seen from a viewpoint: spherical triangles, or square blocks of an image.

The paper, sections 2 and 4.2: from one viewpoint, regions differ in complexity. Each is measured with a few rays.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.complexity import measures
from tracer.core.arrays import Floats
from tracer.core.device import divide, multiplicity, to_unit, upload
from tracer.core.hashing import mix
from tracer.viewpoint.item_buffer import Viewpoints, world_ray
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.surfaces import Subject


@dataclass(frozen=True)
class Regions:
    """What the K rays of each region hit.

    Every measure has the shape (...) of the regions and counts the background as a surface.
    """

    surfaces: int
    """Number of surfaces of the subject."""
    same: NDArray[np.uint32]
    """(..., K): for each ray, how many of the K rays of its region hit the same surface, or miss if it misses."""
    hit: NDArray[np.bool_]
    """(..., K): whether the ray hit anything."""

    @cached_property
    def entropy(self) -> Floats:
        """Entropy in bits of the surfaces that are hit, 0 to log2 K."""
        return measures.ray_entropy(self.same)

    @cached_property
    def gini(self) -> Floats:
        """Gini-Simpson index of the surfaces that are hit, 0 to 1 - 1 / K."""
        return measures.ray_gini(self.same)

    @cached_property
    def distinct(self) -> Floats:
        """How many different surfaces are hit, including the background."""
        return measures.ray_distinct(self.same)

    @cached_property
    def viewpoint_complexity(self) -> Floats:
        """C(V) of the paper with the region as the image."""
        return measures.ray_viewpoint(self.same, self.hit, self.surfaces)


def look_through_triangles(subject: Subject, eyes: Floats, triangles: Floats, rays: int, seed: int = 0) -> Regions:
    """Return the T regions that are spherical triangles (T, 3, 3) of unit directions, seen from ``eyes`` (T, 3).

    Each has ``rays`` random rays, uniform in solid angle.
    """
    count = len(triangles)
    lane = dr.arange(mi.UInt32, count * rays)
    number, _ = divide(lane, rays)
    key = mix(lane) ^ mix(mi.UInt32(seed) + 0x51ED)
    direction = uniform_in_triangle(corners(triangles, number), to_unit(mix(key)), to_unit(mix(key ^ 0x2545F491)))
    eye = mi.Point3f(*(dr.gather(mi.Float, upload(mi.Float, eyes[:, k]), number) for k in range(3)))
    return regions(subject, mi.Ray3f(eye, direction), rays, (count,))


def look_through_blocks(
    subject: Subject, viewpoint: Viewpoints, lens: Lens, across: int, down: int, side: int
) -> Regions:
    """Return the regions (down, across) that are blocks of an image, with ``side`` x ``side`` rays each.

    ``viewpoint`` holds one viewpoint.
    """
    rays, count = side * side, across * down * side * side
    block, within = divide(dr.arange(mi.UInt32, count), rays)
    row, column = divide(block, across)
    inner_row, inner_column = divide(within, side)
    width, height = dr.opaque(mi.Float, 1 / (across * side)), dr.opaque(mi.Float, 1 / (down * side))
    step = dr.opaque(mi.UInt32, side)
    u, v = (mi.Float(column * step + inner_column) + 0.5) * width, (mi.Float(row * step + inner_row) + 0.5) * height
    ray, _ = world_ray(viewpoint, lens, dr.zeros(mi.UInt32, count), u, v)
    return regions(subject, ray, rays, (down, across))


def regions(subject: Subject, ray: Any, rays: int, shape: tuple[int, ...]) -> Regions:
    """Trace rays that are ordered by region, ``rays`` for each, and return the regions in ``shape``."""
    intersection = subject.scene.ray_intersect_preliminary(ray)
    surface = subject.surface(intersection, ray)
    hit = surface < dr.opaque(mi.UInt32, subject.count)
    dr.eval(surface, hit)
    same = multiplicity(surface, rays)
    return Regions(subject.count, same.numpy().reshape(*shape, rays), hit.numpy().reshape(*shape, rays))


def corners(triangles: Floats, number: Any) -> tuple[Any, Any, Any]:
    """Return the corners (mi.Vector3f) of the triangles (T, 3, 3) with the numbers ``number`` (mi.UInt32)."""
    table = upload(mi.Float, triangles)
    a, b, c = (mi.Vector3f(*(dr.gather(mi.Float, table, 9 * number + 3 * j + k) for k in range(3))) for j in range(3))
    return a, b, c


def uniform_in_triangle(corners: tuple[Any, Any, Any], u: Any, v: Any) -> Any:
    """Return directions (mi.Vector3f) that are uniform in the solid angle of spherical triangles.

    J. Arvo, "Stratified sampling of spherical triangles", SIGGRAPH 1995: of the uniform numbers, u cuts off a triangle
    A B C' with u times the area, and v is the height on the arc from B to C'. The corners are counter-clockwise as seen
    from outside.
    """
    a, b, c = corners
    # The normals of the planes of the great circles, and the angles between these planes.
    ab, bc, ca = (dr.normalize(dr.cross(*pair)) for pair in ((a, b), (b, c), (c, a)))
    alpha, beta, gamma = (dr.safe_acos(-dr.dot(*pair)) for pair in ((ca, ab), (ab, bc), (bc, ca)))
    area = alpha + beta + gamma - dr.pi
    sin_alpha, cos_alpha = dr.sincos(alpha)
    s, t = dr.sincos(u * area - alpha)
    cos_side = dr.dot(a, b)
    p, q = t - cos_alpha, s + sin_alpha * cos_side
    numerator = (q * t - p * s) * cos_alpha - q
    denominator = (q * s + p * t) * sin_alpha
    cosine = dr.clip(dr.select(denominator == 0, 1.0, numerator / denominator), -1, 1)
    toward_c = dr.normalize(c - a * dr.dot(c, a))
    on_ac = cosine * a + dr.safe_sqrt(1 - dr.square(cosine)) * toward_c
    height = 1 - v * (1 - dr.dot(on_ac, b))
    from_b = on_ac - b * dr.dot(on_ac, b)
    length = dr.norm(from_b)
    beside = dr.select(length > 0, from_b / length, 0)
    return dr.normalize(height * b + dr.safe_sqrt(1 - dr.square(height)) * beside)
