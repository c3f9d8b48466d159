"""Entropy of the curvature that is seen."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tracer import complexity
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.sight import Sight
from tracer.viewpoint.subject import Mesh

BINS = 256


@lru_cache(maxsize=4)
def classes(mesh: Mesh) -> NDArray[np.int64]:
    """Return the class (joined vertices,), of 256, of the angle deficit of each vertex: 2 pi - sum of angles."""
    corners = mesh.vertices[mesh.triangles]
    joined = mesh.joined
    angles = np.zeros(joined.max(initial=-1) + 1)
    for k in range(3):
        one, other = (corners[:, (k + step) % 3] - corners[:, k] for step in (1, 2))
        crossed = np.linalg.norm(np.cross(one, other), axis=-1)
        np.add.at(angles, joined[:, k], np.arctan2(crossed, np.sum(one * other, axis=-1)))
    deficit = 2 * np.pi - angles
    span = np.ptp(deficit) if len(deficit) else 0.0
    if span < 1e-5:  # flat or a sphere: one class
        return np.zeros(len(deficit), np.int64)
    return np.minimum((deficit - deficit.min()) / span * BINS, BINS - 1).astype(np.int64)


@measure("curvature_entropy", "most", "mesh")
def curvature_entropy(sight: Sight) -> float:
    """Return the entropy in bits of the Gaussian curvature (angle deficit) of the vertices of what is seen.

    D. Page, A. Koschan, S. Sukumar, B. Roui-Abidi and M. Abidi, "Shape analysis algorithm based on information theory",
    ICIP 2003; here of a view. 0 where no mesh is seen.
    """
    mesh = sight.subject.mesh
    seen = np.zeros(sight.subject.count, bool)
    seen[sight.surfaces] = True
    vertices = np.unique(mesh.joined[seen[mesh.surface]])
    return float(complexity.entropy(np.bincount(classes(mesh)[vertices], minlength=BINS)))
