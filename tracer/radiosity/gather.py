"""Irradiance of points: rays of each hemisphere where it is complex, or spread evenly as ever.

E(x) = sum over triangles T of the integral of L cos. With n_T rays, uniform in T, and what the rays that looked first
saw on average as c_T,

    E = sum_T [ c_T Omega'_T + Omega_T / n_T sum_j (L_j - c_T) cos_j ]

with solid angles Omega and, projected, Omega'. Its expectation is E for any n_T >= 1 and any c_T that the rays j do not
depend on: where complexity misleads, only time is lost. n_T goes as Omega'_T times complexity, mixed with a floor.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.draw import divide
from tracer.hashing import GOLDEN_RATIO, mix
from tracer.radiosity.hemisphere import MOST_RAYS, NOTHING, Division, Points, Regions, See, leave, subdivide, through
from tracer.viewpoint.item_buffer import to_unit

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Gathered:
    """Irradiance and what it took."""

    irradiance: Floats
    """(P, 3)."""
    rays: int
    """Traced, those that looked first too."""


def gather_evenly(see: See, points: Points, rays: int, seed: int = 0) -> Gathered:
    """Return irradiance from ``rays`` rays a point as the cosine is, spread evenly: E = pi / n sum L."""
    total = np.zeros((len(points), 3))
    most = max(1, MOST_RAYS // rays)
    for first in range(0, len(points), most):
        count = min(most, len(points) - first)
        _, radiance = see(cosine_rays(points, first, count, rays, seed))
        sums = [dr.block_sum(channel, rays) for channel in radiance]
        dr.eval(sums)
        total[first : first + count] = np.stack([one.numpy() for one in sums], axis=-1) * (np.pi / rays)
    return Gathered(total, rays * len(points))


def cosine_rays(points: Points, first: int, count: int, rays: int, seed: int) -> mi.Ray3f:
    """Return ``rays`` rays of each of ``count`` points from ``first`` on, a lattice in the disc, shifted at random."""
    point, number = divide(dr.arange(mi.UInt32, count * rays), rays)
    point += dr.opaque(mi.UInt32, first)
    key = mix(point ^ mix(dr.opaque(mi.UInt32, (seed + 0x1B873593) & NOTHING)))
    u = (mi.Float(number) + to_unit(key)) * dr.opaque(mi.Float, 1 / rays)
    v = to_unit(number * GOLDEN_RATIO + mix(key))
    return leave(points, point, mi.warp.square_to_cosine_hemisphere(mi.Point2f(u, v)))


def gather(
    see: See,
    points: Points,
    rays: int,
    division: Division | None = None,
    floor: float = 0.3,
    surfaces: int = 1,
    seed: int = 0,
) -> Gathered:
    """Return irradiance from about ``rays`` rays a point, those that look first among them.

    ``floor``: share of the rest that is spread as the cosine is, whatever is seen there.
    """
    division = division or Division()
    regions = subdivide(see, points, division, surfaces, seed)
    left = rays - regions.rays / max(len(points), 1)
    counts = share_out(regions, len(points), max(left, 0.0), floor, seed)
    return Gathered(estimate(see, points, regions, counts, seed + 1), regions.rays + int(counts.sum()))


def share_out(regions: Regions, points: int, rays: float, floor: float, seed: int = 0) -> Integers:
    """Return how many rays (R,) each region gets, at least one: about ``rays`` a point."""
    projected = regions.pyramid.projected[regions.triangle]
    complexity = projected * np.maximum(regions.complexity, 0)
    of_point = np.bincount(regions.point, complexity, points)[regions.point]
    guided = np.divide(complexity, of_point, out=projected / np.pi, where=of_point > 0)
    wanted = rays * (floor * projected / np.pi + (1 - floor) * guided)
    # Rounded along all regions, so that what one loses the next gains.
    shift = np.random.default_rng([seed, 1]).random()
    return np.maximum(np.diff(np.floor(np.cumsum(wanted) + shift), prepend=np.floor(shift)), 1).astype(np.int64)


def estimate(see: See, points: Points, regions: Regions, counts: Integers, seed: int) -> Floats:
    """Return the irradiance (P, 3) from ``counts`` (R,) rays of each region."""
    solid = regions.pyramid.solid[regions.triangle]
    projected = regions.pyramid.projected[regions.triangle]
    known = np.stack([np.bincount(regions.point, projected * c, len(points)) for c in regions.radiance.T], axis=-1)
    total = [dr.zeros(mi.Float, len(points)) for _ in range(3)]
    ends = np.cumsum(counts)
    begin = 0
    while begin < len(counts):
        spent = ends[begin] - counts[begin]
        end = max(begin + 1, int(np.searchsorted(ends, spent + MOST_RAYS, side="right")))
        some = slice(begin, end)
        starts = (ends[some] - counts[some] - spent).astype(np.uint32)
        region = mi.UInt32(np.repeat(np.arange(end - begin, dtype=np.uint32), counts[some]))
        number = dr.arange(mi.UInt32, dr.width(region)) - dr.gather(mi.UInt32, mi.UInt32(starts), region)
        each = dr.gather(mi.Float, mi.Float((1 / counts[some]).astype(np.float32)), region)
        point, triangle = regions.point[some], regions.triangle[some]
        ray, cosine = through(points, regions.pyramid, point, triangle, region, number, each, seed + begin)
        _, radiance = see(ray)
        weight = cosine * each * dr.gather(mi.Float, mi.Float(solid[some].astype(np.float32)), region)
        at = dr.gather(mi.UInt32, mi.UInt32(point.astype(np.uint32)), region)
        for k in range(3):
            mean = dr.gather(mi.Float, mi.Float(regions.radiance[some, k].astype(np.float32)), region)
            dr.scatter_add(total[k], (radiance[k] - mean) * weight, at)
        dr.eval(total)
        begin = end
    return known + np.stack([one.numpy() for one in total], axis=-1)
