"""Gini-Simpson index of the IDs that pilot rays hit: the chance that two rays of a pixel hit different things.

Where all things differ in colour by the same contrast D, the variance in a pixel is exactly D^2 / 2 times this index:
its root is the share of an edge's standard deviation that geometry explains (E. Simpson, Nature 163, 1949). It takes
the place of the entropy of D. Plemenos, M. Sbert and M. Feixas, "On viewpoint complexity of 3D scenes", section 4.4,
over the floor of all criteria that see geometry alone (``floor``).
"""

from __future__ import annotations

from tracer.core.arrays import Floats
from tracer.criteria.floor import over_floor
from tracer.criteria.registry import Evidence, criterion


@criterion("shape_gini", needs_radiance=False)
def shape_gini(evidence: Evidence) -> Floats:
    """Return sqrt(sqrt(G) + FLOOR) (H, W); G is the index of shape IDs."""
    return over_floor(evidence.complexity.shape_gini)


@criterion("face_gini", needs_radiance=False)
def face_gini(evidence: Evidence) -> Floats:
    """Return sqrt(sqrt(G) + FLOOR) (H, W); G is the index of face IDs."""
    return over_floor(evidence.complexity.face_gini)
