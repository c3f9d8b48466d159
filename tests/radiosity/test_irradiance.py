"""Irradiance against analysis: boxes, form factors, and no bias wherever the rays go."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.radiosity import irradiance as module
from tracer.radiosity.groups import alone, neighbours
from tracer.radiosity.guide import Guidance, make_guide
from tracer.radiosity.hemisphere import Division, subdivide
from tracer.radiosity.irradiance import gather, sums_of_rays
from tracer.radiosity.lattice import evenly
from tracer.radiosity.strata import Strata
from tracer.radiosity.warp import Warp, knots, warped

from .scenery import POINTS, UP, box, busy, nothing, plane, square

DEEP = Division("entropy", 0.3, 2, 16)
WAYS = {"evenly": lambda guide: evenly, "strata": Strata, "warp": Warp}


def guide(see, groups, division=DEEP, seed=0, floor=0.5, kind="entropy", worth=0.0):
    return make_guide(
        see, groups, division, Guidance(kind, members=1, worth=worth, overall=0.0, floor=floor), 10000, seed
    )


@pytest.mark.parametrize("way", WAYS)
def test_a_shining_box_has_no_variance(way):
    groups = alone(POINTS)
    found = gather(box, groups, 50, WAYS[way](guide(box, groups)))
    assert found.irradiance == pytest.approx(np.full((7, 3), np.pi), rel=2e-6)
    assert found.rays == 350
    assert gather(nothing, groups, 64, WAYS[way](guide(nothing, groups))).irradiance.max() == 0


def test_strata_have_no_variance_in_a_shining_box_even_where_it_is_busy():
    groups = alone(POINTS)
    found = gather(box, groups, 400, Strata(guide(busy, groups)))
    assert found.irradiance == pytest.approx(np.full((7, 3), np.pi), rel=1e-5)


def test_strata_give_each_triangle_its_share_and_at_least_one_ray():
    groups = alone(POINTS)
    made = guide(busy, groups)
    rays = 1000
    point = dr.repeat(dr.arange(mi.UInt32, 7), rays)
    number = dr.tile(dr.arange(mi.UInt32, rays), 7)
    _, weight = Strata(made)(point, number, mi.UInt32(rays), 3)
    weight = weight.numpy().reshape(7, rays)
    for k in range(7):
        here = slice(made.first[k], made.first[k + 1])
        projected = made.regions.pyramid.projected[made.regions.triangle[here]]
        count = len(projected)
        # Rays of a triangle stand for its projected solid angle over their number, and all for pi.
        assert weight[k].sum() == pytest.approx(np.pi, rel=1e-5)
        sure = 1.01 * count / rays
        expected = rays * ((1 - sure) * made.share[here] + sure / count)
        times = [
            np.isclose(weight[k], p / n, rtol=1e-4).any() for p, n in zip(projected, np.round(expected), strict=True)
        ]
        assert np.mean(times) > 0.3
        assert len(np.unique(weight[k].round(9))) <= count


def test_strata_with_more_triangles_than_rays_are_even():
    groups = alone(UP)
    few = gather(busy, groups, 4, Strata(guide(busy, groups)), seed=5)
    assert few.irradiance == pytest.approx(gather(busy, groups, 4, evenly, seed=5).irradiance, rel=1e-6)


def test_a_warp_without_a_reason_changes_nothing():
    groups = alone(POINTS)
    even = gather(busy, groups, 256, evenly, 9).irradiance
    flat = gather(busy, groups, 256, Warp(guide(busy, groups, floor=1.0)), 9).irradiance
    assert flat == pytest.approx(even, rel=1e-4)


def test_points_that_are_not_guided_go_evenly():
    groups = alone(POINTS)
    warp = Warp(guide(busy, groups))
    some = np.arange(7) % 2 == 0
    found = gather(busy, groups, 256, warp, 9, some).irradiance
    assert np.array_equal(found[some], gather(busy, groups, 256, warp, 9).irradiance[some])
    assert np.array_equal(found[~some], gather(busy, groups, 256, evenly, 9).irradiance[~some])
    assert warped(guide(nothing, groups, worth=1.5)) is evenly


def test_places_have_the_density_that_light_is_weighed_by():
    """A ray and a place on a light that go the same way have the same density."""
    groups = alone(POINTS)
    warp = Warp(guide(busy, groups))
    count = 1 << 14
    group, number = dr.arange(mi.UInt32, count) % 7, dr.arange(mi.UInt32, count)
    toward, weight = warp(group, number, mi.UInt32(count), 0)
    density = np.pi / count / weight.numpy()
    assert density.min() < 0.6
    assert density.max() > 2
    again = warp.density_of(group, toward).numpy()
    # But for places on the very edge of two strips.
    assert np.isclose(again, density, rtol=1e-3).mean() > 0.999


def test_knots_by_brute_force():
    """The share of a density that lies in each strip is the same, along rows and in each of them."""
    density = np.random.default_rng(2).random((3, 8, 8)) ** 3
    density[1, 2] = 0
    density[2, :, :4] = 0
    rows, columns = knots(density)
    fine = np.repeat(np.repeat(density, 500, axis=1), 500, axis=2)
    middle = (np.arange(4000) + 0.5) / 4000
    for k in range(3):
        row = np.searchsorted(rows[k], middle, side="right") - 1
        of_rows = np.bincount(row, fine[k].sum(axis=1), 8)
        assert of_rows == pytest.approx(np.full(8, of_rows.mean()), rel=0.02)
        for strip in range(8):
            column = np.searchsorted(columns[k, strip], middle, side="right") - 1
            of_columns = np.bincount(column, fine[k][row == strip].sum(axis=0), 8)
            assert of_columns == pytest.approx(np.full(8, of_columns.mean()), rel=0.03)


def test_a_warp_has_the_density_it_says():
    """The weights are one over a density: their mean is 1 wherever they are averaged over the hemisphere."""
    groups = alone(UP)
    made = guide(busy, groups)
    count = 1 << 18
    zero, number = dr.zeros(mi.UInt32, count), dr.arange(mi.UInt32, count)
    toward, weight = Warp(made)(zero, number, mi.UInt32(count), 0)
    toward, weight = np.array(toward).T, weight.numpy()
    assert weight.sum() == pytest.approx(np.pi, rel=1e-3)
    table = made.regions.pyramid
    for triangle in range(4, 20):
        planes = np.cross(table.corners[triangle], np.roll(table.corners[triangle], -1, axis=0))
        inside = (toward @ planes.T > 0).all(axis=1)
        assert weight[inside].sum() == pytest.approx(table.projected[triangle], rel=0.02)
    # More rays where it is busy than the cosine would send there.
    there = toward[:, 0] > 0.6
    assert there.mean() > 1.5 * weight[there].sum() / np.pi


# Rays begin a little above their plane, and so does what they are to see: as far off as it should be.
START = plane(64).outside
FACTORS = {
    "parallel": (square([0, 0, 1 + START], [1, 0, 0], [0, 1, 0]), 0.199825),
    "perpendicular": (square([0, 0, START], [0, 1, 0], [0, 0, 1]), 0.200044),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FACTORS)
@pytest.mark.parametrize("way", WAYS)
def test_form_factors_of_unit_squares(name, way):
    """J. R. Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-11 and C-14."""
    see, expected = FACTORS[name]

    def factor(seed):
        groups = neighbours(plane(64, seed), 256)
        made = make_guide(see, groups, Division("deviation", 0.6, 2, 64), Guidance(worth=0, overall=0), 1, seed + 100)
        return gather(see, groups, 512, WAYS[way](made), seed).irradiance[:, 0].mean() / np.pi

    found = np.array([factor(seed) for seed in range(12)])
    stderr = found.std(ddof=1) / np.sqrt(len(found))
    assert stderr < 2e-4
    # Six comparisons at 5 standard errors of 12 seeds (Student): false alarms below 1 in 400.
    assert abs(found.mean() - expected) < 5 * stderr + 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("floor", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("kind", ["entropy", "deviation"])
@pytest.mark.parametrize("way", ["strata", "warp"])
def test_no_bias_wherever_the_rays_go(kind, floor, way):
    groups = alone(UP)
    truth = gather(busy, groups, 1 << 21).irradiance[0, 0]
    division = Division(kind, 0.2, depth=2)
    found = np.array(
        [
            gather(
                busy, groups, 300, WAYS[way](guide(busy, groups, division, 1000 + seed, floor, kind)), seed
            ).irradiance[0, 0]
            for seed in range(100)
        ]
    )
    stderr = found.std() / np.sqrt(len(found))
    # Twelve comparisons at 4 standard errors: false alarms below 1 in 1000.
    assert abs(found.mean() - truth) < 4 * stderr


def test_a_guide_that_knows_where_radiance_varies_gains():
    groups = neighbours(plane(16), 256)
    truth = gather(busy, groups, 1 << 14, seed=77).irradiance
    made = make_guide(busy, groups, Division("deviation", 0.6, 2, 128), Guidance(), 1, 0)
    errors = [
        np.mean([np.mean((gather(busy, groups, 256, way, seed).irradiance - truth) ** 2) for seed in range(4)])
        for way in (evenly, Warp(made))
    ]
    assert errors[1] < errors[0] / 1.5


def test_wavefronts_change_nothing(monkeypatch):
    groups = alone(POINTS)
    ways = [evenly, Strata(guide(busy, groups)), Warp(guide(busy, groups))]
    whole = [gather(busy, groups, 500, way).irradiance for way in ways]
    monkeypatch.setattr(module, "MOST_RAYS", 1100)
    for before, way in zip(whole, ways, strict=True):
        assert gather(busy, groups, 500, way).irradiance == pytest.approx(before, rel=1e-5)


def test_regions_know_their_group():
    regions = subdivide(busy, neighbours(plane(16), 64), Division(rays=16))
    assert np.unique(regions.group).tolist() == [0, 1, 2, 3]


def test_a_million_rays_are_added_up_in_double_precision():
    """Like terms added one after the other in single precision are off by 1e-4 and more, by threads and blocks."""
    count = 1 << 20
    channels = [dr.full(mi.Float, value, 2 * count) for value in (0.1, 0.7)]
    found = sums_of_rays(channels, count)
    assert found == pytest.approx(np.tile(count * np.array([0.1, 0.7], np.float32).astype(float), (2, 1)), rel=1e-9)
