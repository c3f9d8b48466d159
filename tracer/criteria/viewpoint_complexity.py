"""Viewpoint complexity C(V) of each block of pixels: the share of the scene's surfaces that are visible in it, plus the
share of it that they cover.

D. Plemenos, M. Sbert and M. Feixas, "On viewpoint complexity of 3D scenes", sections 3.1 and 4.4: rays are cast into a
block in proportion to its complexity. Half of C(V) is the second share, which has no more to say in a block within a
surface; so an empty background has least, and edges beyond it do not matter unless many surfaces meet.
"""

from __future__ import annotations

from tracer.core.arrays import Floats
from tracer.criteria.floor import over_floor
from tracer.criteria.registry import Evidence, criterion


@criterion("viewpoint_complexity", needs_radiance=False)
def viewpoint_complexity(evidence: Evidence) -> Floats:
    """Return sqrt(sqrt(C(V) / 2) + FLOOR) (H, W): C(V) is 0 to 2, and 0 where rays see nothing."""
    return over_floor(evidence.complexity.viewpoint / 2.0)
