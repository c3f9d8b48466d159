"""Geometry contrast: how unequal cos / d^2 is at the surfaces that the rays of a pixel hit.

J. Rigau, M. Feixas and M. Sbert, "New contrast measures for pixel supersampling", CGI 2002, and "Entropy-based adaptive
sampling", Graphics Interface 2003, equations 9 and 10. It is 0 where all rays meet surfaces at the same distance and
slant, and where no ray meets a surface. The papers compare it with a threshold, after the first rays of a pixel. Here
it allocates the whole budget at once, over the same floor as ``shape_entropy``, so that the picture stays unbiased.
"""

from __future__ import annotations

from tracer.core.arrays import Floats
from tracer.criteria.floor import over_floor
from tracer.criteria.registry import Evidence, criterion


@criterion("geometry_contrast", needs_radiance=False)
def geometry_contrast(evidence: Evidence) -> Floats:
    """Return sqrt(sqrt(C) + FLOOR) (H, W); C is the contrast 1 - H / log K of K pilot rays."""
    return over_floor(evidence.complexity.geometry_contrast)
