"""Hemispheres are split where what they see is complex."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.radiosity import hemisphere
from tracer.radiosity.hemisphere import KINDS, NOTHING, Division, Points, subdivide

GENERATOR = np.random.default_rng(1)
NORMALS = GENERATOR.normal(size=(7, 3))
POINTS = Points(GENERATOR.normal(size=(7, 3)), NORMALS / np.linalg.norm(NORMALS, axis=1, keepdims=True))
UP = Points(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))


def box(ray):
    """Everything is one thing that shines alike."""
    return dr.zeros(mi.UInt32, dr.width(ray)), mi.Color3f(1.0) + dr.zeros(mi.Float, dr.width(ray))


def nothing(ray):
    return dr.zeros(mi.UInt32, dr.width(ray)) + NOTHING, dr.zeros(mi.Color3f, dr.width(ray))


def busy(ray):
    """Where x > 0.6 every ray hits something else, which shines or not."""
    cell = mi.UInt32(dr.abs(ray.d.y) * 9999)
    there = ray.d.x > 0.6
    return dr.select(there, cell, 0), mi.Color3f(dr.select(there & (cell % 2 == 0), 5.0, 0.0))


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_simple_is_not_split(kind):
    threshold = 2.5 if kind in ("distinct", "viewpoint_complexity") else 0.1
    regions = subdivide(box, POINTS, Division(kind, threshold, depth=3))
    assert regions.triangle.tolist() == [0, 1, 2, 3] * 7
    assert regions.point.tolist() == np.repeat(np.arange(7), 4).tolist()
    assert regions.radiance == pytest.approx(np.ones((28, 3)))
    assert regions.rays == 28 * 8


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_busy_is_split(kind):
    threshold = {"distinct": 1.5, "viewpoint_complexity": 1.00015}.get(kind, 0.1)
    regions = subdivide(busy, UP, Division(kind, threshold, depth=3, rays=16), surfaces=10000)
    table = regions.pyramid
    assert table.solid[regions.triangle].sum() == pytest.approx(2 * np.pi)
    assert table.projected[regions.triangle].sum() == pytest.approx(np.pi)
    deep = regions.triangle >= table.first[3]
    sees_it = (table.corners[regions.triangle, :, 0] > 0.6).any(axis=1)
    assert deep[(table.corners[regions.triangle, :, 0] > 0.7).all(axis=1)].all()
    assert not deep[(table.corners[regions.triangle, :, 0] < 0.3).all(axis=1)].any()
    assert sees_it[regions.complexity > threshold].all()


def test_depth_is_a_limit():
    regions = subdivide(busy, UP, Division(threshold=-1.0, depth=2))
    assert len(regions.triangle) == 64
    assert regions.rays == 8 * (4 + 16 + 64)


@pytest.mark.parametrize("kind", KINDS)
def test_complexity_of_rays_by_brute_force(kind):
    seen = GENERATOR.integers(0, 4, (6, 16))
    light = GENERATOR.random((6, 16))
    identity = np.where(seen == 3, NOTHING, seen)

    def see(ray):
        return mi.UInt32(identity.ravel().astype(np.uint32)), mi.Color3f(mi.Float(light.ravel().astype(np.float32)))

    places = Points(np.zeros((6, 3)), np.tile([0.0, 0, 1], (6, 1)))
    table = hemisphere.pyramid(0)
    division = Division(kind, rays=16)
    values, radiance = hemisphere.look(see, places, table, np.arange(6), np.zeros(6, int), division, 50, 0)
    for row, shine, value in zip(seen, light, values, strict=True):
        p = np.bincount(row) / 16
        p = p[p > 0]
        expected = {
            "entropy": -np.sum(p * np.log2(p)),
            "gini": 1 - np.sum(p**2),
            "distinct": len(p),
            "viewpoint_complexity": len(set(row[row < 3])) / 50 + np.mean(row < 3),
            "deviation": shine.std(),
        }[kind]
        assert value == pytest.approx(expected, abs=1e-5)
    assert radiance[:, 1] == pytest.approx(light.mean(axis=1), rel=1e-5)


def test_wavefronts_change_nothing(monkeypatch):
    whole = subdivide(box, POINTS, Division(threshold=-1.0, depth=1))
    monkeypatch.setattr(hemisphere, "MOST_RAYS", 100)
    parts = subdivide(box, POINTS, Division(threshold=-1.0, depth=1))
    assert np.array_equal(whole.triangle, parts.triangle)
    assert np.allclose(whole.radiance, parts.radiance)
