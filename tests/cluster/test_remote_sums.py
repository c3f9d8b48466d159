"""Where sums are, and what a worker is given to go on from them or to draw them again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.cluster.remote_sums import RemoteSums
from tracer.cluster.sums import packed
from tracer.cluster.units import Unit, UnitRequest
from tracer.cluster.work_balancer import Region
from tracer.sampling.wavefront import Stretch

PIXELS = 40
ONES = np.ones(PIXELS, np.uint32)


@pytest.fixture
def sums():
    return RemoteSums([Region(0, PIXELS)], rounds=[Stretch(0, 0 * ONES, ONES)])


def request_for(first=10, size=10, anew=False, **more):
    ones = np.ones(size, np.uint32)
    return UnitRequest(Unit(Region(first, size, **more), ones, ones), "a", anew, 0.0)


def test_a_unit_goes_on_from_the_sums_that_there_are(sums):
    source, skip, first, size, stretches = sums.arguments(request_for(source="sums", skip=7))
    assert (source, skip, first, size, len(stretches)) == ("sums", 7, 10, 10, 1)
    assert sums.arguments(request_for(source="sums", skip=7, anew=True))[:4] == (None, 0, 10, 10)


def test_what_goes_on_has_the_last_round_and_what_is_drawn_anew_has_all(sums):
    sums.rounds.append(Stretch(0, ONES, 2 * ONES))
    going_on = request_for(source="sums")
    going_on.unit.goal = 2 * going_on.unit.goal
    *_, last = sums.arguments(going_on)
    going_on.anew = True
    *_, both = sums.arguments(going_on)
    assert [(each.before[0], each.after[0]) for each in last] == [(1, 2)]
    assert [(each.before[0], each.after[0]) for each in both] == [(0, 1), (1, 2)]


def test_what_is_drawn_anew_goes_on_from_the_sums_of_an_earlier_render(sums):
    arrays = [np.arange(PIXELS, dtype=np.uint32), np.arange(PIXELS) / 3]
    sums.begun = arrays
    before, skip, *_ = sums.arguments(request_for(source="sums", skip=7, anew=True))
    assert skip == 0
    assert np.array_equal(before["sums"].packed(), packed(arrays, 10, 10))


def test_a_part_of_a_region_takes_its_place_and_the_rest_stays_where_it_was():
    sums = RemoteSums([Region(0, 10), Region(10, 20, "old", 3), Region(30, 10)])
    sums.put(Region(15, 5, "new"))
    assert sums.regions == [
        Region(0, 10),
        Region(10, 5, "old", 3),
        Region(15, 5, "new"),
        Region(20, 10, "old", 13),
        Region(30, 10),
    ]
    sums.put(Region(0, 10, "whole"))
    assert sums.regions[0] == Region(0, 10, "whole")


@given(st.lists(st.integers(1, 10), min_size=1, max_size=10), st.randoms(use_true_random=False))
def test_regions_always_cover_the_picture(sizes, random):
    """Parts are put in any order; each then has its own sums."""
    firsts = np.cumsum([0, *sizes]).tolist()
    parts = [Region(first, size, f"sums {first}") for first, size in zip(firsts, sizes, strict=False)]
    sums = RemoteSums([Region(0, firsts[-1], "whole")])
    for part in random.sample(parts, len(parts)):
        sums.put(part)
        covered = [pixel for region in sums.regions for pixel in range(region.first, region.first + region.size)]
        assert covered == list(range(firsts[-1]))
        assert all(region.skip == region.first for region in sums.regions if region.source == "whole")
    assert sums.regions == parts


def test_the_rounds_of_a_region_are_those_up_to_its_goal():
    more = ONES.copy()
    more[:10] = 5
    sums = RemoteSums([], rounds=[Stretch(0, 0 * ONES, ONES), Stretch(0, ONES, more), Stretch(0, more, 2 * more)])
    region = Region(20, 8)
    found = sums.rounds_of(region, 2 * ONES[region.pixels])
    assert [set(each.after[20 - each.first_pixel :][:8]) for each in found] == [{1}, {2}]
    assert len(sums.rounds_of(region, ONES[region.pixels])) == 1  # the second has none of its samples, the third more
    assert len(sums.rounds_of(Region(0, 10), 5 * ONES[:10])) == 2
