"""Shares of rays: as complexity has it, with a floor, and none where they would not pay."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.core.hashing import mix
from tracer.radiosity.groups import alone, neighbours
from tracer.radiosity.guide import FEWEST, MANY, Guidance, division_for, gain, make_guide, shares, sure_gain
from tracer.radiosity.hemisphere import WHOLE, Division, Regions, subdivide
from tracer.radiosity.triangle_hierarchy import pyramid

from .scenery import POINTS, UP, box, busy, plane


@pytest.mark.parametrize("floor", [0.0, 0.5, 1.0])
def test_rays_go_where_it_is_complex(floor):
    regions = subdivide(busy, alone(POINTS), Division(depth=2, rays=16))
    share = shares(regions, len(POINTS), floor)
    even = regions.pyramid.projected[regions.triangle] / np.pi
    for point in range(7):
        here = regions.group == point
        weight = even[here] * regions.complexity[here, WHOLE]
        weight = weight / weight.sum() if weight.sum() > 0 else even[here]
        assert share[here] == pytest.approx(floor * even[here] + (1 - floor) * weight)
        assert share[here].sum() == pytest.approx(1)


def test_where_nothing_is_complex_rays_go_as_the_cosine():
    regions = subdivide(box, alone(UP), Division(depth=2))
    assert shares(regions, 1, 0.0) == pytest.approx(np.full(4, 0.25))
    assert gain(regions, 1, 0.0) == pytest.approx([1])


def made_of(deviation, complexity):
    """Return the four regions of one group; columns are of all rays that looked, and of each half."""
    table = pyramid(0)
    zeros = np.zeros(4, int)
    return Regions(table, zeros, np.arange(4), np.array(complexity), np.ones((4, 3)), np.array(deviation), 0)


def test_the_best_shares_gain_most():
    """Omega' sigma^2 / density^1.5 is least, for densities that add up to 1, where they are as sigma^0.8."""
    sigma = np.array([0.1, 0.5, 2.0, 3.0])
    deviation = np.repeat(sigma[:, None], 3, axis=1)
    even = made_of(deviation, np.ones((4, 3)))
    assert gain(even, 1, 0.0) == pytest.approx([1])
    best = gain(made_of(deviation, deviation**0.8), 1, 0.0)[0]
    density = 4 * sigma**0.8 / np.sum(sigma**0.8)
    assert best == pytest.approx(np.sum(sigma**2) / np.sum(sigma**2 / density**1.5))
    generator = np.random.default_rng(3)
    for _ in range(50):
        other = np.repeat(generator.random((4, 1)), 3, axis=1) + 1e-3
        assert gain(made_of(deviation, other), 1, 0.0)[0] <= best + 1e-9
    # A floor gives some of it back, and all of it is even again.
    assert 1 < gain(made_of(deviation, deviation**0.8), 1, 0.5)[0] < best
    assert gain(made_of(deviation, deviation), 1, 1.0) == pytest.approx([1])


def test_a_gain_is_sure_if_all_groups_agree():
    def groups_of(gains):
        """Two triangles of each group: half of the rays in one that varies, as a share of 1 + x does, x = gain."""
        table, count = pyramid(0), len(gains)
        deviation = np.zeros((4 * count, 3))
        deviation[::4] = 1
        # With a floor of 0 the density of the first triangle is its share of complexity: gain = density^1.5.
        complexity = np.ones((4 * count, 3))
        density = np.asarray(gains) ** (2 / 3)
        complexity[::4] = (3 * density / (4 - density))[:, None]
        ones = np.ones((4 * count, 3))
        group = np.repeat(np.arange(count), 4)
        return Regions(table, group, np.tile(np.arange(4), count), complexity, ones, deviation, 0)

    sizes = np.full(3, 100)
    assert sure_gain(groups_of([1.5, 1.5, 1.5]), sizes, 0.0) == pytest.approx(1.5)
    spread = sure_gain(groups_of([3.0, 1.5, 0.75]), sizes, 0.0)
    # A third of the root of 2 ln(2)^2.
    assert spread == pytest.approx(1.5 * np.exp(-np.sqrt(2) * np.log(2) / 3))
    assert sure_gain(groups_of([3.0, 1.0]), np.array([1, 10**6]), 0.0) == pytest.approx(1, rel=1e-4)


def test_one_half_judges_the_other():
    """A light that one ray hit by chance is in one half only: by it alone a guide would seem to gain."""
    found = np.array([[1.0, 0, 2], [1.0, 2, 0], [0.0, 0, 0], [0.0, 0, 0]])
    alike = np.repeat(found[:, :1], 3, axis=1)
    assert gain(made_of(alike, alike), 1, 0.5)[0] > 1.4
    assert gain(made_of(found, found), 1, 0.5)[0] < 0.6


def test_a_look_costs_what_it_may():
    guidance = Guidance(members=256, look=1 / 16)
    for rays in (8, 16, 33, 64, 256, 1000, 1 << 14):
        division = division_for(guidance, rays)
        if division is None:
            assert rays < 16
            continue
        assert FEWEST <= division.rays <= MANY
        most = 4 * (2 ** (division.depth + 1) - 1) * division.rays
        assert most <= rays * 256 / 16
        regions = subdivide(busy, neighbours(plane(16), 256), division, 100)
        assert regions.rays <= most


def test_groups_that_are_small_or_gain_nothing_are_not_guided():
    groups = neighbours(plane(16), 64)
    division = Division("entropy", 1.0, 1, 64)
    assert len(make_guide(busy, groups, division, Guidance("entropy", members=64, worth=0, overall=0), 1, 0).share) > 0
    assert len(make_guide(busy, groups, division, Guidance("entropy", members=400), 1, 0).share) == 0
    dark = make_guide(box, groups, division, Guidance("entropy", members=64, overall=0), 1, 0)
    assert len(dark.share) == 0
    assert not dark.guided.any()
    assert dark.first.tolist() == [0] * 5
    assert dark.regions.rays > 0


def test_a_sample_looks_for_all():
    """Half of these groups look first; where they expect little, the others do not look."""
    groups = neighbours(plane(64), 128)
    division = Division("deviation", 0.6, 1, 128)

    def guide(see, **settings):
        return make_guide(see, groups, division, Guidance(members=128, **settings), 1, 0)

    whole = guide(busy, worth=0, overall=0)
    assert whole.guided.all()
    few = guide(busy, overall=1e9)
    assert not few.guided.any()
    assert len(groups) == 32
    assert few.regions.rays == whole.regions.rays // 2
    usual = guide(busy)
    assert usual.regions.rays == whole.regions.rays
    assert usual.guided.any()


def test_what_varies_by_chance_is_not_guided():
    """Every ray sees noise: what deviates most did by chance."""

    def noise(ray):
        bits = mix(dr.reinterpret_array(mi.UInt32, ray.d.x) ^ mix(dr.reinterpret_array(mi.UInt32, ray.d.y)))
        return mi.UInt32(0) + bits, mi.Color3f(dr.select(bits < mi.UInt32(0xFFFFFFFF // 100), 100.0, 0.0))

    groups = neighbours(plane(64), 256)
    guide = make_guide(noise, groups, Division("deviation", 0.6, 2, 128), Guidance(), 1, 0)
    assert guide.guided.mean() < 0.3
