"""Viewpoint complexity C(V) of each block of pixels: the share of the scene's surfaces that are visible in it, plus the
share of the block that they cover.

D. Plemenos, M. Sbert and M. Feixas, "On viewpoint complexity of 3D scenes", sections 3.1 and 4.4: rays are cast into a
block in proportion to its complexity. The share that is covered makes up half of the range of C(V) and is 1 in every
block within a surface. So an empty background has the least complexity, and edges between surfaces hardly matter unless
many surfaces meet.
"""

from __future__ import annotations

from tracer.core.arrays import Floats
from tracer.criteria.floor import over_floor
from tracer.criteria.registry import Evidence, criterion


@criterion("viewpoint_complexity", needs_radiance=False)
def viewpoint_complexity(evidence: Evidence) -> Floats:
    """Return sqrt(sqrt(C(V) / 2) + FLOOR) (H, W); C(V) is 0 to 2, and 0 where rays hit nothing."""
    return over_floor(evidence.complexity.viewpoint / 2.0)
