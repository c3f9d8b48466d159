"""Which surfaces are neighbours, against one pair of triangles after the other."""

import itertools

import numpy as np
import pytest

from tracer.viewpoint.channel import adjacent
from tracer.viewpoint.surfaces import Mesh


def fan(count):
    """Return the corners and triangles of ``count`` triangles around one edge, each with vertices of its own."""
    turn = 2 * np.pi * np.arange(count) / count
    tips = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    axis = np.broadcast_to([[0.0, 0, -1], [0, 0, 1]], (count, 2, 3))
    return np.concatenate([axis, tips[:, None]], axis=1).reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def pairs_by_hand(mesh):
    """Return the pairs of surfaces of which two triangles have two places or more in common."""
    places = [{tuple(mesh.vertices[corner]) for corner in face} for face in mesh.triangles]
    found = {
        tuple(sorted((int(mesh.surface[a]), int(mesh.surface[b]))))
        for a, b in itertools.combinations(range(len(places)), 2)
        if len(places[a] & places[b]) >= 2 and mesh.surface[a] != mesh.surface[b]
    }
    return sorted(found)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7])
def test_all_triangles_at_an_edge_are_neighbours(count):
    vertices, triangles = fan(count)
    found = adjacent(Mesh(vertices, triangles, np.arange(count)))
    assert found.tolist() == [list(pair) for pair in itertools.combinations(range(count), 2)]
    assert found.shape == (count * (count - 1) // 2, 2)


@pytest.mark.parametrize("seed", range(5))
def test_neighbours_of_any_mesh(seed):
    generator = np.random.default_rng(seed)
    vertices = generator.integers(0, 2, (14, 3)).astype(float)  # many of them at one place
    corners = generator.permuted(np.tile(np.arange(14), (40, 1)), axis=1)[:, :3]
    whole = [len({tuple(vertices[k]) for k in face}) == 3 for face in corners]
    triangles = corners[whole]
    mesh = Mesh(vertices, triangles, generator.integers(0, 12, len(triangles)))
    assert [tuple(pair) for pair in adjacent(mesh).tolist()] == pairs_by_hand(mesh)
