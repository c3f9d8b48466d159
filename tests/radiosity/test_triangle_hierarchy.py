"""Triangles of a hemisphere: known solid angles, plain and projected."""

import numpy as np
import pytest

from tracer.radiosity.triangle_hierarchy import projected_solid_angle, pyramid


def test_octants_and_their_parts():
    found = pyramid(1)
    assert found.first.tolist() == [0, 4, 20]
    assert found.solid[:4] == pytest.approx(np.full(4, np.pi / 2))
    assert found.projected[:4] == pytest.approx(np.full(4, np.pi / 4))
    parts = found.children(np.array([0]), 0)[0]
    assert np.sort(found.solid[parts]) == pytest.approx([0.339837] * 3 + [0.551286], abs=1e-6)
    assert np.sort(found.projected[parts]) == pytest.approx([0.090399] * 2 + [0.302300] * 2, abs=1e-6)


def test_every_level_is_the_whole_hemisphere():
    found = pyramid(4)
    for level in range(5):
        part = slice(found.first[level], found.first[level + 1])
        assert found.solid[part].sum() == pytest.approx(2 * np.pi)
        assert found.projected[part].sum() == pytest.approx(np.pi)
        assert found.corners[part, :, 2].min() > -1e-12


@pytest.mark.parametrize("level", [0, 1, 2])
def test_children_lie_in_their_parent(level):
    found = pyramid(3)
    triangles = np.arange(found.first[level], found.first[level + 1])
    parts = found.children(triangles, level)
    assert found.solid[parts].sum(axis=1) == pytest.approx(found.solid[triangles])
    assert found.projected[parts].sum(axis=1) == pytest.approx(found.projected[triangles])
    middle = found.corners[parts].mean(axis=2)
    corners = found.corners[triangles]
    planes = np.cross(corners, np.roll(corners, -1, axis=1))
    assert np.einsum("tek,tck->tec", planes, middle).min() > 0


def test_projected_solid_angle_by_brute_force():
    generator = np.random.default_rng(3)
    corners = generator.normal(size=(5, 3, 3))
    corners[..., 2] = np.abs(corners[..., 2])
    corners /= np.linalg.norm(corners, axis=-1, keepdims=True)
    turned = np.linalg.det(corners) < 0
    corners[turned] = corners[turned][:, ::-1]
    radius, turn = np.sqrt(generator.random(400000)), 2 * np.pi * generator.random(400000)
    x, y = radius * np.cos(turn), radius * np.sin(turn)  # of the disc: area is projected solid angle
    directions = np.stack([x, y, np.sqrt(1 - x * x - y * y)])
    planes = np.cross(corners, np.roll(corners, -1, axis=1))
    inside = np.all(planes @ directions > 0, axis=1).mean(axis=1)
    stderr = np.sqrt(inside * (1 - inside) / 400000)
    # Five comparisons at 4 standard errors: false alarms below 1 in 3000.
    assert np.all(np.abs(projected_solid_angle(corners) - np.pi * inside) < 4 * np.pi * stderr)
