"""Normals of vertices, on one side of the surface: those of a file, or else the mean of the faces around.

Faces should be wound alike, as seen from one side. In many files some are not, and a mean of their normals would point
anywhere.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tracer.core.arrays import Floats, Integers
from tracer.core.sphere import normalised_or_zero

FACES_AT_ONCE = 1 << 20
"""Normals of this many faces are worked out at once."""
DISAGREE = 0.5
"""Faces may be wound differently if the length of the mean of the normals around any vertex is less than this."""


def corner_mean(vertices: Floats, faces: Integers) -> Floats:
    """Return the mean normals (N, 3) of the faces around each vertex, weighted by their angles there, of any length."""
    normals, angles = sums_of_corners(vertices, faces)
    if np.all(np.linalg.norm(normals, axis=1) >= DISAGREE * angles):
        return normals
    wound = alike(faces)
    return normals if wound is None else sums_of_corners(vertices, wound)[0]


def on_one_side(normals: Floats, vertices: Floats, faces: Integers) -> Floats:
    """Return the normals (N, 3) that a file gives, turned to the side of the faces around if they are on either side.

    Those that are worked out from points alone often are.
    """
    for first in range(0, len(faces), FACES_AT_ONCE):
        a, b, c = normals[faces[first : first + FACES_AT_ONCE]].transpose(1, 0, 2)
        if any(np.any(np.sum(one * other, axis=1) < 0) for one, other in ((a, b), (b, c), (c, a))):
            inward = np.sum(normals * corner_mean(vertices, faces), axis=1) < 0
            return np.where(inward[:, None], -normals, normals)
    return normals


def sums_of_corners(vertices: Floats, faces: Integers) -> tuple[Floats, Floats]:
    """Return the sums, of the faces around each vertex, of angles times normals (N, 3), and of angles (N,)."""
    normals, angles = np.zeros(vertices.shape), np.zeros(len(vertices))
    for first in range(0, len(faces), FACES_AT_ONCE):
        some = faces[first : first + FACES_AT_ONCE]
        edges = [normalised_or_zero(vertices[some[:, (k + 1) % 3]] - vertices[some[:, k]]) for k in range(3)]
        across = normalised_or_zero(np.cross(edges[0], edges[1]))
        for k in range(3):
            angle = np.arccos(np.clip(-np.sum(edges[k] * edges[k - 1], axis=1), -1, 1))
            angle[~across.any(axis=1)] = 0  # a face without area has no normal
            angles += np.bincount(some[:, k], angle, len(vertices))
            for axis in range(3):
                normals[:, axis] += np.bincount(some[:, k], angle * across[:, axis], len(vertices))
    return normals, angles


def alike(faces: Integers) -> Integers | None:
    """Return the faces (F, 3), wound alike wherever they share an edge as most of them are; None if they are already.

    Two faces at an edge are wound alike if they run along it in opposite directions. Every face stands for two nodes,
    one as it is and one turned round, and nodes that are wound alike are linked: the nodes of a surface then fall into
    two halves, of which either has each of its faces once. A surface with one side alone, such as Moebius's, stays as
    it is. Edges of more than two faces link none.
    """
    starts, ends = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    key = np.minimum(starts, ends) * (int(faces.max()) + 1) + np.maximum(starts, ends)
    order = np.argsort(key, kind="stable")
    key, forward, face = key[order], (starts < ends)[order], order // 3
    is_new = np.append(True, key[1:] != key[:-1])
    group = np.cumsum(is_new) - 1
    first = np.flatnonzero(is_new & (np.bincount(group)[group] == 2))
    one, other, turned = face[first], face[first + 1], forward[first] == forward[first + 1]
    if not turned.any():
        return None
    count = len(faces)
    rows = np.concatenate([one, one + count])
    columns = np.concatenate([other + count * turned, other + count * ~turned])
    links: Any = coo_array((np.ones(len(rows), np.int8), (rows, columns)), shape=(2 * count, 2 * count))
    label = connected_components(links, directed=False)[1].reshape(2, count)
    surface, is_first = np.minimum(*label), label[0] <= label[1]
    most_are_first = 2 * np.bincount(surface, is_first) >= np.bincount(surface)
    return np.where((is_first == most_are_first[surface])[:, None], faces, faces[:, ::-1])
