"""Irradiance against analysis: boxes, form factors, and no bias wherever the rays go."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.radiosity import gather as module
from tracer.radiosity.gather import gather, gather_evenly, share_out
from tracer.radiosity.hemisphere import NOTHING, Division, Points, subdivide

from .test_hemisphere import POINTS, UP, box, busy, nothing

DEEP = Division(threshold=0.3, depth=2)


def square(corner, first, second):
    """Return what a parallelogram of radiance 1 looks like."""
    corner, first, second = (np.array(each, float) for each in (corner, first, second))
    normal = np.cross(first, second)

    def see(ray):
        n, c = mi.Vector3f(normal.tolist()), mi.Point3f(corner.tolist())
        distance = dr.dot(c - ray.o, n) / dr.dot(ray.d, n)
        at = ray(distance) - c
        a = dr.dot(at, mi.Vector3f(first.tolist())) / float(first @ first)
        b = dr.dot(at, mi.Vector3f(second.tolist())) / float(second @ second)
        hit = (distance > 0) & (a >= 0) & (a < 1) & (b >= 0) & (b < 1)
        return dr.select(hit, mi.UInt32(1), mi.UInt32(NOTHING)), mi.Color3f(dr.select(hit, 1.0, 0.0))

    return see


def test_a_shining_box_has_no_variance():
    for found in (gather_evenly(box, POINTS, 50), gather(box, POINTS, 50), gather(box, POINTS, 200, DEEP)):
        assert found.irradiance == pytest.approx(np.full((7, 3), np.pi), rel=2e-6)
    assert gather(nothing, POINTS, 64).irradiance.max() == 0


PARALLEL = square([0, 0, 1], [1, 0, 0], [0, 1, 0])
BESIDE = square([0, 0, 0], [0, 1, 0], [0, 0, 1])
FACTORS = {"parallel": (PARALLEL, 0.199825), "perpendicular": (BESIDE, 0.200044)}


@pytest.mark.parametrize("name", FACTORS)
@pytest.mark.parametrize("guided", [False, True])
def test_form_factors_of_unit_squares(name, guided):
    """J. R. Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11 and C-14."""
    see, expected = FACTORS[name]
    count = 64
    generator = np.random.default_rng(7)
    cells = np.stack(np.meshgrid(np.arange(count), np.arange(count)), axis=-1).reshape(-1, 2)
    places = np.column_stack([(cells + generator.random(cells.shape)) / count, np.zeros(len(cells))])
    points = Points(places, np.tile([0.0, 0, 1], (len(places), 1)))
    way = (lambda seed: gather(see, points, 512, DEEP, seed=seed)) if guided else None
    way = way or (lambda seed: gather_evenly(see, points, 512, seed))
    found = np.array([way(seed).irradiance[:, 0].mean() / np.pi for seed in range(12)])
    stderr = found.std(ddof=1) / np.sqrt(len(found))
    assert stderr < 2e-4
    # Four comparisons at 5 standard errors of 12 seeds (Student): false alarms below 1 in 600.
    assert abs(found.mean() - expected) < 5 * stderr + 1e-6


@pytest.mark.parametrize("floor", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("kind", ["entropy", "deviation"])
def test_no_bias_wherever_the_rays_go(kind, floor):
    truth = gather_evenly(busy, UP, 1 << 21).irradiance[0, 0]
    division = Division(kind, 0.2, depth=2)
    found = np.array([gather(busy, UP, 400, division, floor, 10000, seed).irradiance[0, 0] for seed in range(200)])
    stderr = found.std() / np.sqrt(len(found))
    # Six comparisons at 4 standard errors: false alarms below 1 in 2500.
    assert abs(found.mean() - truth) < 4 * stderr


def test_rays_are_as_many_as_asked_for():
    for rays in (100, 1000):
        found = gather(busy, POINTS, rays, Division(depth=1, rays=4))
        assert found.rays / len(POINTS) == pytest.approx(rays, rel=0.1)


@pytest.mark.parametrize("floor", [0.0, 0.5, 1.0])
def test_rays_go_where_it_is_complex(floor):
    regions = subdivide(busy, POINTS, Division(depth=2, rays=16))
    counts = share_out(regions, len(POINTS), 10000, floor)
    projected = regions.pyramid.projected[regions.triangle]
    assert counts.min() >= 1
    of_points = np.bincount(regions.point, counts)
    assert of_points == pytest.approx(np.full(7, 10000), rel=0.01)
    for point in range(7):
        here = regions.point == point
        weight = projected[here] * regions.complexity[here]
        weight = weight / weight.sum() if weight.sum() > 0 else projected[here] / np.pi
        expected = 10000 * (floor * projected[here] / np.pi + (1 - floor) * weight)
        assert np.abs(counts[here] - np.maximum(expected, 1)).max() <= 1


def test_where_nothing_is_complex_rays_go_as_the_cosine():
    regions = subdivide(box, UP, Division(depth=2))
    assert share_out(regions, 1, 4000, 0.0).tolist() == pytest.approx([1000] * 4, abs=1)


def test_wavefronts_change_nothing(monkeypatch):
    whole = gather(busy, POINTS, 500, DEEP, floor=0.2)
    monkeypatch.setattr(module, "MOST_RAYS", 700)
    parts = gather(busy, POINTS, 500, DEEP, floor=0.2)
    assert parts.rays == whole.rays
    assert parts.irradiance == pytest.approx(whole.irradiance, rel=0.3)
