"""Hemispheres are split where what they see is complex."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.radiosity import hemisphere
from tracer.radiosity.cosine_triangle import table_of
from tracer.radiosity.groups import Points, alone, neighbours
from tracer.radiosity.hemisphere import HALVES, KINDS, NOTHING, UNSEEN, WHOLE, Division, subdivide

from .scenery import GENERATOR, POINTS, UP, box, busy, plane

THRESHOLDS = {"distinct": 1.5, "viewpoint_complexity": 1.00015, "deviation": 0.6}


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_simple_is_not_split(kind):
    threshold = 2.5 if kind in ("distinct", "viewpoint_complexity") else THRESHOLDS.get(kind, 0.1)
    regions = subdivide(box, alone(POINTS), Division(kind, threshold, depth=3))
    assert regions.triangle.tolist() == [0, 1, 2, 3] * 7
    assert regions.group.tolist() == np.repeat(np.arange(7), 4).tolist()
    assert regions.mean == pytest.approx(np.ones((28, 3)))
    assert regions.deviation == pytest.approx(np.zeros((28, 3)), abs=1e-3)
    assert regions.rays == 28 * 8


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_busy_is_split(kind):
    threshold = THRESHOLDS.get(kind, 0.1)
    regions = subdivide(busy, alone(UP), Division(kind, threshold, depth=3, rays=16), surfaces=10000)
    table = regions.pyramid
    assert table.solid[regions.triangle].sum() == pytest.approx(2 * np.pi)
    assert table.projected[regions.triangle].sum() == pytest.approx(np.pi)
    deep = regions.triangle >= table.first[3]
    sees_it = (table.corners[regions.triangle, :, 0] > 0.6).any(axis=1)
    assert deep[(table.corners[regions.triangle, :, 0] > 0.7).all(axis=1)].all()
    assert not deep[(table.corners[regions.triangle, :, 0] < 0.3).all(axis=1)].any()
    assert sees_it[regions.complexity[:, WHOLE] > threshold].all()


def test_depth_is_a_limit():
    regions = subdivide(busy, alone(UP), Division(threshold=-1.0, depth=2))
    assert len(regions.triangle) == 64
    assert regions.rays == 8 * (4 + 16 + 64)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "deviation"])
def test_complexity_of_rays_by_brute_force(kind):
    seen = GENERATOR.integers(0, 4, (6, 16))
    light = GENERATOR.random((6, 16))
    identity = np.where(seen == 3, NOTHING, seen)

    def see(ray):
        return mi.UInt32(identity.ravel().astype(np.uint32)), mi.Color3f(mi.Float(light.ravel().astype(np.float32)))

    groups = alone(Points(np.zeros((6, 3)), np.tile([0.0, 0, 1], (6, 1))))
    parts = table_of(0)
    division = Division(kind, rays=16)
    values, mean, deviation = hemisphere.look(see, groups, parts, np.arange(6), np.zeros(6, int), division, 50, 0)
    for row, value in zip(seen, values, strict=True):
        p = np.bincount(row) / 16
        p = p[p > 0]
        expected = {
            "entropy": -np.sum(p * np.log2(p)),
            "gini": 1 - np.sum(p**2),
            "distinct": len(p),
            "viewpoint_complexity": len(set(row[row < 3])) / 50 + np.mean(row < 3),
        }[kind]
        assert value == pytest.approx([expected] * 3, abs=1e-5)
    for column, some in ((WHOLE, slice(None)), (HALVES[0], slice(0, None, 2)), (HALVES[1], slice(1, None, 2))):
        assert mean[:, column] == pytest.approx(light[:, some].mean(axis=1), rel=1e-5)
        assert deviation[:, column] == pytest.approx(light[:, some].std(axis=1), rel=1e-4)


def test_deviation_is_in_units_of_what_the_group_sees():
    found = [subdivide(busy, alone(UP), Division("deviation", 9.0, 0, 4096), seed=seed) for seed in range(2)]

    def brighter(ray):
        identity, radiance = busy(ray)
        return identity, 100 * radiance

    bright = subdivide(brighter, alone(UP), Division("deviation", 9.0, 0, 4096))
    assert bright.complexity == pytest.approx(found[0].complexity, rel=1e-4)
    whole = np.sum(found[0].mean[:, WHOLE] * np.pi / 4) / np.pi
    assert found[0].complexity == pytest.approx(np.hypot(found[0].deviation, UNSEEN * found[0].mean) / whole, rel=1e-6)
    assert found[1].complexity == pytest.approx(found[0].complexity, rel=0.3)


def test_groups_look_from_all_their_points():
    """One half of a group sees a light, the other does not: each triangle sees it in about half of its rays."""
    points = plane(8)
    groups = neighbours(points, 64)

    def see(ray):
        left = ray.o.x < 0.5
        return mi.UInt32(0) + mi.UInt32(left), mi.Color3f(mi.Float(left))

    found = subdivide(see, groups, Division("entropy", 2.0, 0, 1024))
    share = (points.places[:, 0] < 0.5).mean()
    assert len(found.mean) == 4
    assert found.mean[:, WHOLE] == pytest.approx(np.full(4, share), abs=0.08)


def test_only_so_many_are_split_and_only_in_chosen_groups():
    groups = neighbours(plane(8), 32)
    whole = subdivide(busy, groups, Division(threshold=-1.0, depth=2, widest=0.5))
    # Of 4 triangles 2 are split, and of their 8 parts 4.
    assert np.bincount(whole.group).tolist() == [2 + 4 + 16] * 2
    assert whole.rays == 2 * 8 * (4 + 8 + 16)
    assert np.unique(subdivide(busy, groups, Division(), chosen=np.array([1])).group).tolist() == [1]
    assert len(subdivide(busy, groups, Division(), chosen=np.zeros(0, int)).group) == 0


def test_groups_without_hope_are_looked_at_no_further():
    groups = neighbours(plane(8), 32)
    division = Division(threshold=-1.0, depth=2)
    found = subdivide(busy, groups, division, hopeful=lambda so_far: np.array([True, False]))
    assert np.bincount(found.group).tolist() == [64, 16]
    assert found.rays == 8 * (4 + 16 + 64 + 4 + 16)


def test_regions_of_other_groups_are_put_together():
    groups = neighbours(plane(8), 16)
    division = Division(threshold=-1.0, depth=1)
    parts = [subdivide(busy, groups, division, chosen=np.array(some)) for some in ([1, 3], [0, 2])]
    both = parts[0].together(parts[1])
    assert both.group.tolist() == np.repeat(np.arange(4), 16).tolist()
    assert both.rays == parts[0].rays + parts[1].rays
    assert np.array_equal(both.where(both.group % 2 == 1).mean, parts[0].mean)


def test_wavefronts_change_nothing(monkeypatch):
    whole = subdivide(box, alone(POINTS), Division(threshold=-1.0, depth=1))
    monkeypatch.setattr(hemisphere, "MOST_RAYS", 100)
    parts = subdivide(box, alone(POINTS), Division(threshold=-1.0, depth=1))
    assert np.array_equal(whole.triangle, parts.triangle)
    assert np.allclose(whole.mean, parts.mean)
