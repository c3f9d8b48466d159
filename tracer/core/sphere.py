"""The sphere of viewpoints: directions spread over it, spherical triangles, distances on it. Unit vectors (..., 3)."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from tracer.core.arrays import Floats, Integers

GOLDEN = (1 + 5**0.5) / 2
"""The golden ratio."""


def normalised(vectors: ArrayLike) -> Floats:
    """Return vectors (..., 3) scaled to unit length. Raises ValueError for a vector of length 0."""
    vectors = np.asarray(vectors, np.float64)
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    if not np.all(length > 0):
        raise ValueError("a direction has no length")
    return vectors / length


def normalised_or_zero(vectors: ArrayLike) -> Floats:
    """Return vectors (..., 3) scaled to unit length; those of length 0, as of faces without area, stay as they are."""
    vectors = np.asarray(vectors, np.float64)
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def octants() -> tuple[Floats, Integers]:
    """Return the ends of the three axes (6, 3) and the spherical triangles between them (8, 3), as in the paper."""
    axes = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], np.float64)
    triangles = [(x, y, z) if (x + y + z) % 2 == 0 else (x, z, y) for x in (0, 1) for y in (2, 3) for z in (4, 5)]
    return axes, np.array(triangles)


@cache
def icosphere(level: int) -> tuple[Floats, Integers]:
    """Return directions (10 * 4^level + 2, 3) and triangles (20 * 4^level, 3), counter-clockwise from outside.

    These are the icosahedron's, with each triangle split in four ``level`` times. Level 3 has the 642 viewpoints of
    X. Bonaventura and others, "A survey of viewpoint selection methods for polygonal models", Entropy 20(5), 2018.

    Example:

    >>> from tracer.core.sphere import icosphere
    >>> directions, triangles = icosphere(3)
    >>> directions.shape, triangles.shape
    ((642, 3), (1280, 3))
    """
    if level == 0:
        corners = [(0, s, t * GOLDEN) for s in (-1, 1) for t in (-1, 1)]
        points = normalised([(p[k:] + p[:k]) for k in range(3) for p in corners])
        edge = np.sort(np.linalg.norm(points[:, None] - points, axis=-1), axis=None)[len(points)]
        near = np.linalg.norm(points[:, None] - points, axis=-1) < 1.1 * edge
        corners_of = [
            (a, b, c)
            for a in range(12)
            for b in range(a + 1, 12)
            for c in range(b + 1, 12)
            if near[a, b] and near[b, c] and near[a, c]
        ]
        return points, np.array([outward(points, face) for face in corners_of])
    return split(*icosphere(level - 1))


def outward(points: Floats, face: tuple[int, int, int]) -> tuple[int, int, int]:
    """Return the corners of a triangle in the order that is counter-clockwise from outside."""
    a, b, c = face
    return face if np.dot(np.cross(points[b] - points[a], points[c] - points[a]), points[a]) > 0 else (a, c, b)


def split(points: Floats, triangles: Integers) -> tuple[Floats, Integers]:
    """Return points, and triangles (4 T, 3): each triangle (T, 3) split in four at the middles of its edges."""
    edges, edge_numbers = np.unique(np.sort(sides(triangles), axis=-1).reshape(-1, 2), axis=0, return_inverse=True)
    middle = len(points) + edge_numbers.reshape(-1, 3)
    a, b, c = triangles.T
    ab, bc, ca = middle.T
    parts = [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
    split_triangles = np.stack([np.stack(part, axis=-1) for part in parts], axis=1).reshape(-1, 3)
    return np.concatenate([points, normalised(points[edges].sum(axis=1))]), split_triangles


def sides(triangles: Integers) -> Integers:
    """Return the edges (T, 3, 2) of triangles (T, 3)."""
    return np.stack([triangles, np.roll(triangles, -1, axis=-1)], axis=-1)


def neighbours(triangles: Integers) -> list[Integers]:
    """Return for each point the numbers of the points that it shares an edge with, in ascending order."""
    edges = np.unique(np.sort(sides(triangles).reshape(-1, 2), axis=-1), axis=0)
    directed = np.concatenate([edges, edges[:, ::-1]])
    directed = directed[np.lexsort((directed[:, 1], directed[:, 0]))]
    return np.split(directed[:, 1], np.searchsorted(directed[:, 0], np.arange(1, int(triangles.max()) + 1)))


def middle(a: ArrayLike, b: ArrayLike) -> Floats:
    """Return the middle (..., 3) of the shorter great arc between directions that are not opposite."""
    return normalised(np.asarray(a, np.float64) + np.asarray(b, np.float64))


def angle(a: ArrayLike, b: ArrayLike) -> Floats:
    """Return the angle in radians between directions (..., 3), exact for small angles too (W. Kahan)."""
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    return 2 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))


def solid_angle(a: ArrayLike, b: ArrayLike, c: ArrayLike) -> Floats:
    """Return the solid angle of spherical triangles in steradians, negative if clockwise from outside.

    A. Van Oosterom and J. Strackee, IEEE Transactions on Biomedical Engineering 30(2), 1983, equation 8.
    """
    a, b, c = (np.asarray(corner, np.float64) for corner in (a, b, c))

    def dot(u: Floats, v: Floats) -> Floats:
        return np.sum(u * v, axis=-1)

    volume = dot(a, np.cross(b, c))
    return 2 * np.arctan2(volume, 1 + dot(a, b) + dot(b, c) + dot(c, a))


def evenly(count: int) -> Floats:
    """Return ``count`` directions (count, 3) evenly spread along a spiral (R. Swinbank and R. Purser, 2006)."""
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    turn = 2 * np.pi * k / GOLDEN
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=-1)


def frame(direction: ArrayLike, up: ArrayLike = (0.0, 0.0, 1.0)) -> tuple[Floats, Floats]:
    """Return the directions (right, up), (..., 3) each, of cameras that look along ``direction``.

    Where ``up`` is parallel to ``direction``, another direction takes its place.
    """
    direction = normalised(direction)
    up = np.broadcast_to(normalised(up), direction.shape)
    replacement = np.roll(up, 1, axis=-1)  # not parallel to it, unless all three components are equal
    if np.allclose(replacement, up):
        replacement = np.array([1.0, 0.0, 0.0])
    is_parallel = np.abs(np.sum(direction * up, axis=-1, keepdims=True)) > 1 - 1e-6
    right = normalised(np.cross(direction, np.where(is_parallel, replacement, up)))
    return right, np.cross(right, direction)
