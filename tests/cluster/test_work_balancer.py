"""Regions cover the picture, whatever is cut; units are dealt out so that all are done at about the same time."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.cluster.work_balancer import Region, deal, divide, samples_of, seconds_of, split

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


def even_counts(total, pixels=10_000):
    return np.full(pixels, total // pixels, np.uint32)


def test_a_first_round_is_cut_in_about_five_units_a_worker_but_not_in_small_ones():
    whole = Region(0, 10_000)
    assert len(divide([whole], even_counts(100_000_000), 2)) == 10
    assert len(divide([whole], even_counts(400_000), 2)) == 2
    # Four units of the least size: two for each of three workers, so that none has one more than another.
    assert len(divide([whole], even_counts(4 << 18), 3)) == 6


def test_parts_of_a_first_round_go_by_samples():
    counts = np.repeat([18_000, 2_000], 5000).astype(np.uint32)
    found = divide([Region(0, 5000), Region(5000, 5000)], counts, 2)
    assert [sum(region.first < 5000 for region in found), len(found)] == [9, 10]


def test_small_work_is_not_cut_into_crumbs():
    """Two seconds in all, of which a unit has at least 0.4."""
    counts = even_counts(2_000_000)
    assert len(divide([Region(0, 10_000, pace=1e-6)], counts, 9)) == 5


def test_a_scheduler_of_many_workers_can_keep_up():
    """It is busy 4 ms with each unit, and 500 workers are done with 1000 seconds of work in two."""
    counts = even_counts(1_000_000_000)
    assert len(divide([Region(0, 10_000, pace=1e-6)], counts, 500)) * 4e-3 <= 2 * 1.01


def test_a_part_ends_with_the_pixel_that_fills_it():
    ones = np.ones(10, np.uint32)
    assert [part.size for part in split(Region(0, 10), ones, 2)] == [5, 5]
    assert [part.size for part in split(Region(0, 4), np.array([1, 1, 8, 2], np.uint32), 2)] == [3, 1]


def test_what_was_never_drawn_is_expected_to_take_the_mean():
    regions = [Region(0, 1, pace=1.0), Region(1, 1), Region(2, 1, pace=3.0)]
    assert seconds_of(regions, np.array([1, 10, 2], np.uint32)) == [1, 20, 6]


@given(st.lists(st.integers(1, 20), min_size=1, max_size=7), st.integers(1, 3))
def test_what_nobody_has_is_done_within_grahams_bound(seconds, workers):
    """At most 4/3 - 1/(3 m) of the best, found by trying all."""
    regions = [Region(k, 1, worker="gone") for k in range(len(seconds))]
    chosen = deal(regions, seconds, names := "abc"[:workers])

    def longest(whose):
        return max(sum(s for s, who in zip(seconds, whose, strict=True) if who == name) for name in names)

    best = min(longest(whose) for whose in itertools.product(names, repeat=len(seconds)))
    assert longest(chosen) <= (4 / 3 - 1 / (3 * workers)) * best + 1e-9


@pytest.mark.parametrize(("other", "moved"), [(0.95, 0), (0.8, 1)])
def test_sums_move_only_if_that_saves_a_tenth_of_the_unit(other, moved):
    regions = [Region(k, 1, worker="aab"[k], source=object()) for k in range(3)]
    assert deal(regions, [1.0, 1.0, other], ["a", "b"])[:2].count("b") == moved


@pytest.mark.parametrize(("size", "moved"), [(1_000, 1), (1_000_000, 0)])
def test_large_sums_stay_where_they_are(size, moved):
    """A million pixels take 5 s, more than the 4 s that could be saved."""
    regions = [Region(k * size, size, worker="a", source=object()) for k in range(2)]
    assert deal(regions, [4.0, 4.0], ["a", "b"]).count("b") == moved


def test_both_are_busy_with_a_move():
    """Ten units of 1 s, each 0.5 s to move: with k moved one is done after 10 - k / 2, the other after 3 k / 2."""
    regions = [Region(k, 100_000, worker="a", source=object()) for k in range(10)]
    best = min(range(11), key=lambda k: max(10 - k / 2, 3 * k / 2))
    assert deal(regions, [1.0] * 10, ["a", "b"]).count("b") == best == 5
