"""Entropy of the curvature that is seen."""

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
"""Of deficits from -2 pi to 2 pi: the last is that of 2 pi alone."""
LEAST, SPAN = -2 * np.pi, 4 * np.pi
ROUNDING = 1e-3
"""Classes that a deficit may be below the limit of one: those of regular solids are on some, but for rounding."""


def deficits(mesh: Mesh) -> Floats:
    """Return the angle deficit of each place (P,) of vertices in radians: 2 pi - sum of the angles of its faces."""
    corners, joined = mesh.vertices[mesh.triangles], mesh.joined
    angles = np.zeros(len(mesh.places))
    for k in range(3):
        one, other = (corners[:, (k + step) % 3] - corners[:, k] for step in (1, 2))
        crossed = np.linalg.norm(np.cross(one, other), axis=-1)
        np.add.at(angles, joined[:, k], np.arctan2(crossed, np.sum(one * other, axis=-1)))
    return 2 * np.pi - angles


@lru_cache(maxsize=4)
def classes(mesh: Mesh) -> NDArray[np.int64]:
    """Return the class (P,), of 256, of the angle deficit of each place of vertices."""
    place = (BINS - 1) * (deficits(mesh) - LEAST) / SPAN + ROUNDING
    return np.clip(place.astype(np.int64), 0, BINS - 1)


@measure("curvature_entropy", "most", "vertices")
def curvature_entropy(sight: Sight) -> float:
    """Return the entropy in bits of the Gaussian curvature (angle deficit) of the vertices that are seen.

    D. Page, A. Koschan, S. Sukumar, B. Roui-Abidi and M. Abidi, "Shape analysis algorithm based on information theory",
    ICIP 2003; of a view in the program of the survey (github.com/limdor/quoniam), whose classes these are, the same for
    all meshes. Unlike there, vertices at one place are one, and shares are of the vertices seen instead of all, so that
    they sum to 1. 0 where no vertex is seen.
    """
    assert sight.vertices is not None
    return float(measures.entropy(np.bincount(classes(sight.subject.mesh)[sight.vertices], minlength=BINS)))
