"""Rays of hemispheres in strata: each triangle gets as many rays as it deserves, at least one.

N rays are handed out to the triangles of a group in turn, so that each triangle T gets its share to within one ray. Its
n_T rays form a lattice with a shift of its own, distributed as the cosine, and each has the weight Omega'_T / n_T. The
weights add up to pi whatever n_T is, so that a patch that sends light along the rays sends exactly its power. (Rule 2
of the paper, which takes the cosine of the middle of a triangle, does not have this property.)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.device import to_unit, upload
from tracer.core.hashing import GOLDEN_RATIO, mix
from tracer.radiosity.cosine_triangle import cosine_in_triangle, table_of
from tracer.radiosity.guide import Guide
from tracer.radiosity.lattice import lattice, spread

SPARE = 1.01
"""Rays set aside for each triangle so that it gets at least one: one, with a margin for single precision."""


@dataclass
class Stratum:
    """The triangle that each ray is in."""

    guided: Any
    """mi.Bool: whether it is in any."""
    region: Any
    """mi.UInt32: number of the region of the guide."""
    ray: Any
    """mi.UInt32: number of the ray among those of its point in the triangle."""
    count: Any
    """mi.UInt32: number of rays of its point in the triangle, at least 1."""
    bits: Any
    """mi.UInt32: random bits of the triangle of the point."""


class Strata:
    """Directions in the triangles of a guide, a ``lattice.Way``.

    Rays of groups that have no triangles, or more triangles than rays, are spread evenly.
    """

    def __init__(self, guide: Guide) -> None:
        regions, counts = guide.regions, np.diff(guide.first)
        total = np.cumsum(guide.share)
        begin = np.concatenate([[0.0], total])[guide.first[:-1]]
        until = total - np.repeat(begin, counts)
        until[guide.first[1:][counts > 0] - 1] = 1
        self.groups = guide.groups
        self.some = len(guide.share) > 0
        self.first = upload(mi.UInt32, guide.first)
        self.until = upload(mi.Float, until)
        self.triangle = upload(mi.UInt32, regions.triangle)
        self.projected = upload(mi.Float, regions.pyramid.projected[regions.triangle])
        self.parts = table_of(regions.pyramid.depth)
        self.halvings = int(np.ceil(np.log2(max(int(counts.max(initial=1)), 2))))

    def __call__(self, point: Any, ray_index: Any, rays: Any, seed: int) -> tuple[Any, Any]:
        """Return local directions (mi.Vector3f), z the normal, and their weights (mi.Float), see ``lattice.Way``."""
        bits, u, v = lattice(point, ray_index, rays, seed)
        even = mi.warp.square_to_cosine_hemisphere(mi.Point2f(u, v))
        if not self.some:
            return even, dr.pi / mi.Float(rays)
        stratum = self.hand_out(point, ray_index, rays, bits)
        triangle = dr.gather(mi.UInt32, self.triangle, stratum.region, stratum.guided)
        v = to_unit(ray_index * GOLDEN_RATIO + mix(stratum.bits))
        local = cosine_in_triangle(self.parts, triangle, spread(stratum.ray, stratum.count, stratum.bits), v)
        weight = dr.gather(mi.Float, self.projected, stratum.region, stratum.guided) / mi.Float(stratum.count)
        return dr.select(stratum.guided, local, even), dr.select(stratum.guided, weight, dr.pi / mi.Float(rays))

    def hand_out(self, point: Any, ray_index: Any, rays: Any, bits: Any) -> Stratum:
        """Return the triangle of each ray; ``bits``: random bits of the point."""
        ray_count = mi.Float(rays)
        group = self.groups.group(point)
        begin = dr.gather(mi.UInt32, self.first, group)
        count = dr.gather(mi.UInt32, self.first, group + 1) - begin
        sure = SPARE * mi.Float(count) / ray_count
        guided = (count > 0) & (sure < 1)
        shift = to_unit(bits)

        def first_ray(region: Any) -> Any:
            """Return the number of the first ray of a triangle (``region``, counted within its group)."""
            share = dr.gather(mi.Float, self.until, begin + region - 1, guided & (region > 0))
            place = (1 - sure) * share + sure * mi.Float(region) / mi.Float(dr.maximum(count, 1))
            return mi.UInt32(mi.Int32(dr.ceil(ray_count * dr.select(region >= count, 1, place) - shift)))

        low, high = dr.zeros(mi.UInt32, dr.width(point)), mi.UInt32(count)
        for _ in range(self.halvings):
            middle = (low + high) >> 1
            past = first_ray(middle) <= ray_index
            low, high = dr.select(past, middle, low), dr.select(past, high, middle)
        begins, ends = first_ray(low), first_ray(low + 1)
        bits_of_triangle = mix(bits ^ mix(low + 0x3C6EF372))
        return Stratum(guided, begin + low, ray_index - begins, dr.maximum(ends - begins, 1), bits_of_triangle)
