"""Divide the hemispheres of points where what they see is complex (the paper, section 4.2.2).

Every hemisphere begins as four spherical triangles. Each is looked through with a few rays; one that sees something
more complex than a threshold is split in four, as long as a depth is not reached. (The paper says "or", with which all
are split as deep as that.) All points go in one wavefront, level after level.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, get_args

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.draw import divide
from tracer.hashing import GOLDEN_RATIO, mix
from tracer.pilot import multiplicity
from tracer.radiosity.pyramid import Pyramid, pyramid
from tracer.viewpoint.item_buffer import gather_rows, to_unit
from tracer.viewpoint.regions import corners, uniform_in_triangle

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
MOST_RAYS = 1 << 22
"""In one wavefront."""
Kind = Literal["entropy", "gini", "distinct", "viewpoint_complexity", "deviation"]
KINDS: tuple[str, ...] = get_args(Kind)
See = Callable[[Any], tuple[Any, Any]]
"""From rays (mi.Ray3f) to what each hits: its ID (mi.UInt32, ``NOTHING`` if it misses) and radiance (mi.Color3f)."""
NOTHING = 0xFFFFFFFF


@dataclass(frozen=True)
class Points:
    """Where hemispheres stand."""

    places: Floats
    """(P, 3)."""
    normals: Floats
    """(P, 3), unit."""

    def __len__(self) -> int:
        return len(self.places)


@dataclass(frozen=True)
class Division:
    """How to divide hemispheres."""

    kind: Kind = "entropy"
    """Complexity: bits or Gini index of the IDs seen, how many there are, C(V); or the deviation of radiance, which is
    not complexity but what complexity stands for."""
    threshold: float = 0.3
    """A triangle that is more complex is split."""
    depth: int = 2
    """Times that a triangle is split at most."""
    rays: int = 8
    """With which a triangle is looked through."""


@dataclass(frozen=True)
class Regions:
    """Spherical triangles that divide the hemispheres of points, point after point. Arrays (R, ...)."""

    pyramid: Pyramid
    point: Integers
    triangle: Integers
    """Number in the pyramid."""
    complexity: Floats
    radiance: Floats
    """(R, 3): mean over the rays that looked."""
    rays: int
    """That looked, in all triangles, those that were split too."""


def subdivide(see: See, points: Points, division: Division, surfaces: int = 1, seed: int = 0) -> Regions:
    """Return the divided hemispheres of all points. ``surfaces``: how many IDs there are, for C(V)."""
    table = pyramid(division.depth)
    point, triangle = np.repeat(np.arange(len(points)), 4), np.tile(np.arange(4), len(points))
    parts: list[tuple[Any, ...]] = []
    rays = 0
    for level in range(division.depth + 1):
        complexity, radiance = look(see, points, table, point, triangle, division, surfaces, seed + 7919 * level)
        rays += division.rays * len(point)
        split = (complexity > division.threshold) & (level < division.depth)
        parts.append((point[~split], triangle[~split], complexity[~split], radiance[~split]))
        point, triangle = np.repeat(point[split], 4), table.children(triangle[split], level).ravel()
        if not len(point):
            break
    points_of, triangles, values, radiances = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(points_of, kind="stable")
    return Regions(table, points_of[order], triangles[order], values[order], radiances[order], rays)


def look(
    see: See,
    points: Points,
    table: Pyramid,
    point: Integers,
    triangle: Integers,
    division: Division,
    surfaces: int,
    seed: int,
) -> tuple[Floats, Floats]:
    """Return the complexity (R,) and mean radiance (R, 3) of triangles seen from points, both given by number (R,)."""
    count = division.rays
    most = max(1, MOST_RAYS // count)
    found: list[tuple[Floats, Floats]] = []
    for first in range(0, len(point), most):
        some = slice(first, first + most)
        region, number = divide(dr.arange(mi.UInt32, len(point[some]) * count), count)
        each = dr.opaque(mi.Float, 1 / count)
        ray, _ = through(points, table, point[some], triangle[some], region, number, each, seed + first)
        identity, radiance = see(ray)
        dr.eval(identity, radiance)
        same = mi.Float(multiplicity(identity, count))
        value = complexity_of(division.kind, same, identity != NOTHING, radiance, count, surfaces)
        mean = [dr.block_sum(channel, count) * each for channel in radiance]
        dr.eval(value, mean)
        found.append((value.numpy().astype(np.float64), np.stack([one.numpy() for one in mean], axis=-1)))
    if not found:
        return np.zeros(0), np.zeros((0, 3))
    return np.concatenate([one for one, _ in found]), np.concatenate([two for _, two in found]).astype(np.float64)


def complexity_of(kind: Kind, same: Any, hit: Any, radiance: Any, count: int, surfaces: int) -> Any:
    """Return the complexity (mi.Float) of each group of ``count`` rays; ``same``: how many of it hit what each hit."""
    if kind == "entropy":
        return -dr.block_sum(dr.log2(same / count), count) / count
    if kind == "gini":
        return 1 - dr.block_sum(same, count) / count**2
    if kind == "distinct":
        return dr.block_sum(1 / same, count)
    if kind == "viewpoint_complexity":
        visible = dr.block_sum(dr.select(hit, 1 / same, 0), count)
        return visible / surfaces + dr.block_sum(dr.select(hit, mi.Float(1), 0), count) / count
    grey = mi.luminance(radiance)
    mean = dr.block_sum(grey, count) / count
    return dr.safe_sqrt(dr.block_sum(dr.square(grey), count) / count - dr.square(mean))


def through(
    points: Points,
    table: Pyramid,
    point: Integers,
    triangle: Integers,
    region: Any,
    number: Any,
    each: Any,
    seed: int,
) -> tuple[Any, Any]:
    """Return rays through triangles and their cosines with the normal.

    ``point`` and ``triangle`` (R,) say what the regions are, ``region`` (mi.UInt32) which of them each ray is of,
    ``number`` which ray of the region it is, and ``each`` one over how many rays that region has. The rays of a region
    are a Fibonacci lattice, shifted at random: spread evenly, each uniform in the triangle's solid angle.
    """
    key = mix(region ^ mix(dr.opaque(mi.UInt32, (seed + 0x68E31DA4) & NOTHING)))
    u = (mi.Float(number) + to_unit(key)) * each
    v = to_unit(number * GOLDEN_RATIO + mix(key))
    which = dr.gather(mi.UInt32, mi.UInt32(triangle.astype(np.uint32)), region)
    local = uniform_in_triangle(corners(table.corners, which), dr.minimum(u, 1 - dr.epsilon(mi.Float)), v)
    at = dr.gather(mi.UInt32, mi.UInt32(point.astype(np.uint32)), region)
    return leave(points, at, local), local.z


def leave(points: Points, point: Any, local: Any) -> Any:
    """Return rays from points (by number, mi.UInt32) in directions (mi.Vector3f) of their frames; the normal is z."""
    normal = gather_rows(points.normals, point)
    place = gather_rows(points.places, point)
    outside = dr.max(dr.abs(place)) + 1
    origin = place + normal * (outside * mi.math.RayEpsilon)
    return mi.Ray3f(mi.Point3f(origin), mi.Frame3f(normal).to_world(local))
