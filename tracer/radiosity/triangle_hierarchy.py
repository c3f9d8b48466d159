"""The spherical triangles that a hemisphere is divided into: four, each split in four, and so on.

They are the same for every patch, in the patch's own frame with the normal as z, so one table serves all patches.
Triangle k of a level is split into the triangles 4 k to 4 k + 3 of the next level.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.sphere import angle, normalised, solid_angle, split


@dataclass(frozen=True)
class Pyramid:
    """All triangles of the levels 0 to ``depth``, level after level."""

    corners: Floats
    """(N, 3, 3): unit directions, counter-clockwise from outside."""
    solid: Floats
    """(N,): solid angle in steradians; 2 pi in each level."""
    projected: Floats
    """(N,): solid angle projected onto the plane of the patch; pi in each level."""
    first: Integers
    """(depth + 2,): number of the first triangle of each level, and as the last entry the number of all triangles."""

    @property
    def depth(self) -> int:
        """Largest number of times that a triangle is split."""
        return len(self.first) - 2

    def children(self, triangles: Integers, level: int) -> Integers:
        """Return the four parts (K, 4) of triangles (K,) of a level."""
        return self.first[level + 1] + 4 * (triangles[:, None] - self.first[level]) + np.arange(4)


@cache
def pyramid(depth: int) -> Pyramid:
    """Return the triangles of a hemisphere that is split ``depth`` times."""
    points = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]], np.float64)
    triangles = np.array([[4, k, (k + 1) % 4] for k in range(4)])
    levels = [points[triangles]]
    for _ in range(depth):
        points, triangles = split(points, triangles)
        levels.append(points[triangles])
    corners = np.concatenate(levels)
    first = np.cumsum([0, *(len(level) for level in levels)])
    return Pyramid(corners, solid_angle(*corners.transpose(1, 0, 2)), projected_solid_angle(corners), first)


def projected_solid_angle(corners: Floats) -> Floats:
    """Return the solid angle of spherical triangles (..., 3, 3) projected along z, in [0, pi].

    Half the sum over edges of their angle times the cosine between z and the normal of the edge's plane (J. H. Lambert,
    Photometria, 1760). Triangles are counter-clockwise from outside, and above the plane z = 0.
    """
    following = np.roll(corners, -1, axis=-2)
    normals = normalised(np.cross(corners, following))
    return 0.5 * np.sum(angle(corners, following) * normals[..., 2], axis=-1)
