"""The entropy of the curvature of the vertices that are seen."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tracer.complexity import measures
from tracer.core.arrays import Floats
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.observation import Sight
from tracer.viewpoint.surfaces import Mesh

BINS = 256
"""There are this many classes of angle deficits from -2 pi to 2 pi; the last class holds 2 pi alone."""
LEAST, SPAN = -2 * np.pi, 4 * np.pi
"""The first class begins at LEAST, and the last one at LEAST + SPAN, both in radians."""
ROUNDING = 1e-3
"""A deficit belongs to a class if it is at most this share of a class below its lower limit.

The deficits of regular solids are on such limits, but for rounding.
"""


def deficits(mesh: Mesh) -> Floats:
    """Return the angle deficit (P,) of each place of vertices in radians: 2 pi minus the angles of the faces there."""
    corners, joined = mesh.vertices[mesh.triangles], mesh.joined
    angles = np.zeros(len(mesh.places))
    for k in range(3):
        first_edge, second_edge = (corners[:, (k + step) % 3] - corners[:, k] for step in (1, 2))
        crossed = np.linalg.norm(np.cross(first_edge, second_edge), axis=-1)
        np.add.at(angles, joined[:, k], np.arctan2(crossed, np.sum(first_edge * second_edge, axis=-1)))
    return 2 * np.pi - angles


@lru_cache(maxsize=4)
def classes(mesh: Mesh) -> NDArray[np.int64]:
    """Return the class (P,), 0 to 255, of the angle deficit of each place of vertices."""
    place = (BINS - 1) * (deficits(mesh) - LEAST) / SPAN + ROUNDING
    return np.clip(place.astype(np.int64), 0, BINS - 1)


@measure("curvature_entropy", "most", "vertices")
def curvature_entropy(sight: Sight) -> float:
    """Return the entropy in bits of the Gaussian curvature (angle deficit) of the vertices that are seen.

    D. Page, A. Koschan, S. Sukumar, B. Roui-Abidi and M. Abidi, "Shape analysis algorithm based on information theory",
    ICIP 2003. The program of the survey (github.com/limdor/quoniam) applies it to views; the classes are those of that
    program, the same for all meshes. Unlike there, vertices at the same place count as one, and shares are of the
    vertices that are seen instead of all vertices, so that they sum to 1. The entropy is 0 if no vertex is seen.
    """
    assert sight.vertices is not None
    return float(measures.entropy(np.bincount(classes(sight.subject.mesh)[sight.vertices], minlength=BINS)))
