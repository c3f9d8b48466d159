"""Regions cover the picture, whatever is cut; units are dealt out so that all are done at about the same time."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tracer.cluster.regions import Region, deal, divide, samples_of, split

COUNTS = st.lists(st.integers(0, 10_000), min_size=1, max_size=200).map(lambda each: np.array(each, np.uint32))


def covers(regions, size):
    ends = [0, *(region.first + region.size for region in regions)]
    return [region.first for region in regions] == ends[:-1] and ends[-1] == size


@given(COUNTS, st.integers(1, 50))
def test_parts_cover_a_region_and_know_their_place_in_its_sums(counts, parts):
    whole = Region(0, len(counts), source="held", skip=7)
    found = split(whole, counts, parts)
    assert covers(found, len(counts))
    assert len(found) <= parts
    assert all(part.skip == 7 + part.first for part in found)
    most = max(samples_of(part, counts) for part in found)
    assert most <= counts.sum() / parts + counts.max()


@given(COUNTS, st.integers(1, 9), st.lists(st.floats(1e-7, 1e-3), min_size=1, max_size=4))
def test_units_of_known_pace_take_no_longer_than_they_may(counts, workers, paces):
    regions = [
        Region(int(each[0]), len(each), pace=paces[k % len(paces)])
        for k, each in enumerate(np.array_split(np.arange(len(counts)), 5))
        if len(each)
    ]
    found = divide(regions, counts, workers)
    assert covers(found, len(counts))
    for region in found:
        pixel = counts[region.first : region.first + region.size].max() * region.pace
        assert samples_of(region, counts) * region.pace <= 1.5 + 2 * pixel


def test_work_is_shared_by_time():
    regions = [Region(k, 1, worker="a", source=object()) for k in range(8)]
    seconds = [8, 1, 1, 1, 1, 1, 1, 2]
    chosen = deal(regions, seconds, ["a", "b"])
    spent = {who: sum(s for s, w in zip(seconds, chosen, strict=True) if w == who) for who in "ab"}
    assert spent == {"a": 8, "b": 8}


def test_sums_stay_where_they_are_if_nothing_is_gained():
    regions = [Region(k, 1000, worker="ab"[k % 2], source=object()) for k in range(6)]
    assert deal(regions, [1.0] * 6, ["a", "b"]) == ["a", "b"] * 3
