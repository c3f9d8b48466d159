"""Rays of hemispheres in strata: into each triangle as many as it deserves, at least one.

N rays are handed out along a group's triangles in turn, so each gets its share to within one. In it they are a lattice
with a shift of its own, distributed as the cosine is, and each stands for Omega'_T / n_T: together for pi, whatever n_T
is. A patch that sends light along them sends all that it has. (The paper's rule 2 takes the cosine of a triangle's
middle, and does not.)
"""

from __future__ import annotations

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
"""Of each triangle's one sure ray: what single precision may take away."""


class Strata:
    """Directions in the triangles of a guide (``lattice.Way``); spread evenly where it has none, or too many."""

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

    def __call__(self, point: Any, number: Any, rays: Any, seed: int) -> tuple[Any, Any]:
        """Return directions and what each stands for."""
        key, u, v = lattice(point, number, rays, seed)
        whole = mi.Float(rays)
        even = mi.warp.square_to_cosine_hemisphere(mi.Point2f(u, v))
        if not self.some:
            return even, dr.pi / whole
        group = self.groups.group(point)
        begin = dr.gather(mi.UInt32, self.first, group)
        count = dr.gather(mi.UInt32, self.first, group + 1) - begin
        sure = SPARE * mi.Float(count) / whole
        guided = (count > 0) & (sure < 1)
        shift = to_unit(key)

        def first_ray(region: Any) -> Any:
            """Return the number of the first ray of a triangle."""
            share = dr.gather(mi.Float, self.until, begin + region - 1, guided & (region > 0))
            place = (1 - sure) * share + sure * mi.Float(region) / mi.Float(dr.maximum(count, 1))
            return mi.UInt32(mi.Int32(dr.ceil(whole * dr.select(region >= count, 1, place) - shift)))

        low, high = dr.zeros(mi.UInt32, dr.width(point)), mi.UInt32(count)
        for _ in range(self.halvings):
            middle = (low + high) >> 1
            past = first_ray(middle) <= number
            low, high = dr.select(past, middle, low), dr.select(past, high, middle)
        begins, ends = first_ray(low), first_ray(low + 1)
        own = mix(key ^ mix(low + 0x3C6EF372))
        inside = dr.maximum(ends - begins, 1)
        triangle = dr.gather(mi.UInt32, self.triangle, begin + low, guided)
        v = to_unit(number * GOLDEN_RATIO + mix(own))
        local = cosine_in_triangle(self.parts, triangle, spread(number - begins, inside, own), v)
        stands_for = dr.gather(mi.Float, self.projected, begin + low, guided) / mi.Float(inside)
        return dr.select(guided, local, even), dr.select(guided, stands_for, dr.pi / whole)
