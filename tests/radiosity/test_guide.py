"""Shares of rays: as complexity has it, with a floor, and none where they would not pay."""

import numpy as np
import pytest

from tracer.radiosity.groups import alone, neighbours
from tracer.radiosity.guide import FEWEST, MANY, Guidance, division_for, gain, make_guide, shares
from tracer.radiosity.hemisphere import Division, subdivide

from .scenery import POINTS, UP, box, busy, plane


@pytest.mark.parametrize("floor", [0.0, 0.5, 1.0])
def test_rays_go_where_it_is_complex(floor):
    regions = subdivide(busy, alone(POINTS), Division(depth=2, rays=16))
    share = shares(regions, len(POINTS), floor)
    even = regions.pyramid.projected[regions.triangle] / np.pi
    for point in range(7):
        here = regions.group == point
        weight = even[here] * regions.complexity[here]
        weight = weight / weight.sum() if weight.sum() > 0 else even[here]
        assert share[here] == pytest.approx(floor * even[here] + (1 - floor) * weight)
        assert share[here].sum() == pytest.approx(1)


def test_where_nothing_is_complex_rays_go_as_the_cosine():
    regions = subdivide(box, alone(UP), Division(depth=2))
    assert shares(regions, 1, 0.0) == pytest.approx(np.full(4, 0.25))
    assert gain(regions, 1, shares(regions, 1, 0.0)) == pytest.approx([1])


def test_the_best_shares_gain_most():
    """Neyman: Omega' sigma is the best allocation, and even rays gain nothing over themselves."""
    regions = subdivide(busy, alone(UP), Division("deviation", 0.6, 2, 256))
    even = regions.pyramid.projected[regions.triangle] / np.pi
    best = even * regions.deviation
    best /= best.sum()
    assert gain(regions, 1, even) == pytest.approx([1])
    most = gain(regions, 1, np.maximum(best, 1e-12))[0]
    assert most > 2
    for _ in range(20):
        other = np.random.default_rng(3).dirichlet(np.ones(len(best))) + 1e-9
        assert gain(regions, 1, other / other.sum())[0] <= most + 1e-9


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
    assert len(make_guide(busy, groups, division, Guidance("entropy", members=64), 1, 0).share) > 0
    assert len(make_guide(busy, groups, division, Guidance("entropy", members=400), 1, 0).share) == 0
    dark = make_guide(box, groups, division, Guidance("entropy", members=64, worth=1.05), 1, 0)
    assert len(dark.share) == 0
    assert dark.first.tolist() == [0] * 5
    assert dark.regions.rays > 0
