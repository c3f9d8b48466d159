"""The paper's rules for the rays of a hemisphere (section 4.2.2), as they are printed, or with the energies made right.

1. The number of rays of a triangle is in proportion to its complexity.
2. The energy of a triangle is in proportion to its area and to the cosine of its average direction.
3. The energy of a ray is in proportion to its cosine.

As printed, energy is neither conserved nor right on average: for the four triangles of a hemisphere, area times cosine
adds up to 3.63 instead of pi, and the mean cosine of a few rays is not that of their triangle. Made right, n_T rays of
uniform density in a triangle of area Omega_T weigh Omega_T cos / n_T each, whose expectation is the integral.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.device import upload
from tracer.core.sphere import normalised
from tracer.radiosity.groups import Groups
from tracer.radiosity.guide import Guide
from tracer.radiosity.hemisphere import WHOLE, Division, Kind, See, subdivide
from tracer.radiosity.lattice import lattice, random_numbers, randomly
from tracer.radiosity.strata import Strata
from tracer.radiosity.uniform_triangle import uniform_in_triangle, uniform_table_of


@dataclass(frozen=True)
class PaperRules:
    """The paper's rules, with what it leaves open."""

    kind: Kind = "distinct"
    """Kind of complexity, see ``Division``: by default the number of faces seen. (The viewpoint complexity C(V) of a
    triangle is nearly 1 wherever all rays hit something, so that all triangles would get as many rays.)"""
    threshold: float = 2.5
    """Complexity above which a triangle is split."""
    depth: int = 1
    """Largest number of times that a triangle is split."""
    look: int = 4
    """Number of rays that look through each triangle, for its complexity."""
    right: bool = False
    """Whether the energies of rays are made right."""

    @property
    def division(self) -> Division:
        """How hemispheres are divided: each point looks for itself."""
        return Division(self.kind, self.threshold, self.depth, self.look)


class PaperRays:
    """Random directions in the triangles of a guide by the paper's rules, a ``lattice.Way``.

    A pass has all rays of each of its points, one after another. Rays of points that have no triangles, or more
    triangles than rays, are those of ``randomly``.
    """

    def __init__(self, guide: Guide, right: bool) -> None:
        """``right``: whether energies are made right, instead of as rules 2 and 3 say."""
        pyramid = guide.regions.pyramid
        middles = normalised(pyramid.corners.sum(axis=1))
        self.strata, self.right = Strata(guide), right
        self.table = uniform_table_of(pyramid.depth)
        self.solid, self.energy = upload(mi.Float, pyramid.solid), upload(mi.Float, pyramid.solid * middles[:, 2])

    def __call__(self, point: Any, ray_index: Any, rays: Any, seed: int) -> tuple[Any, Any]:
        """Return local directions (mi.Vector3f), z the normal, and their weights (mi.Float), see ``lattice.Way``."""
        other, other_weight = randomly(point, ray_index, rays, seed)
        if not self.strata.some:
            return other, other_weight
        bits, _, _ = lattice(point, ray_index, rays, seed)
        stratum = self.strata.hand_out(point, ray_index, rays, bits)
        triangle = dr.gather(mi.UInt32, self.strata.triangle, stratum.region, stratum.guided)
        u, v = random_numbers(stratum.bits, ray_index)
        local = uniform_in_triangle(self.table, triangle, u, v, stratum.guided)
        cosine = dr.maximum(local.z, 0.0)
        if self.right:
            weight = dr.gather(mi.Float, self.solid, triangle, stratum.guided) * cosine / mi.Float(stratum.count)
        else:
            first_of_triangle = dr.select(stratum.guided & (stratum.ray == 0), mi.UInt32(1), mi.UInt32(0))
            number = dr.maximum(dr.cumsum(first_of_triangle), 1) - 1
            total = dr.zeros(mi.Float, dr.width(number))
            dr.scatter_add(total, cosine, number, stratum.guided)
            share = cosine / dr.maximum(dr.gather(mi.Float, total, number, stratum.guided), 1e-20)
            weight = dr.gather(mi.Float, self.energy, triangle, stratum.guided) * share
        return dr.select(stratum.guided, local, other), dr.select(stratum.guided, weight, other_weight)


def paper_guide(see: See, groups: Groups, rules: PaperRules, surfaces: int, seed: int) -> Guide:
    """Return the triangles of groups, with shares of rays in proportion to complexity (rule 1).

    ``groups``: one point each, as every patch looks for itself. ``surfaces``: number of IDs that rays may see.
    """
    regions = subdivide(see, groups, rules.division, surfaces, seed)
    counts = np.bincount(regions.group, minlength=len(groups))
    complexity = np.maximum(regions.complexity[:, WHOLE], 0)
    of_group = np.bincount(regions.group, complexity, len(groups))[regions.group]
    even = 1 / counts[regions.group]
    share = np.divide(complexity, of_group, out=even, where=of_group > 0)
    return Guide(groups, regions, np.concatenate([[0], np.cumsum(counts)]), share)
