"""However a round is cut, every sample is drawn once, beside the same others."""

from importlib.resources import files

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.sampling.wavefront import PACKET, Line, Stretch, lane_pixels
from tracer.scene.view import open_scene
from tracer.session.local_drawer import LocalDrawer


def traced(line, size, first_pixel=0):
    """Return (pixel, sample index, whether it is added) of all lanes of a line, in passes of one size."""
    found = []
    for window in line.passes(size):
        for k, (begin, own, end, base) in enumerate(
            zip(window.begin, window.own, window.end, window.base, strict=True)
        ):
            pixel = first_pixel + window.first_pixel + k
            found += [(pixel, (lane + int(base)) % 2**32, lane >= own) for lane in range(begin, end)]
        assert len(found) % PACKET == 0 or line.taken == line.total
    return found


def packets(lanes):
    """Return for each sample those of its packet."""
    samples = [lane[:2] for lane in lanes]
    return {sample: tuple(samples[k // PACKET * PACKET :][:PACKET]) for k, sample in enumerate(samples)}


def added(lanes):
    return [lane[:2] for lane in lanes if lane[2]]


@st.composite
def begun_rounds(draw):
    """A stretch of few pixels, some with many samples, and the samples that there are of it."""
    some = st.one_of(st.just(0), st.integers(0, 5), st.integers(0, 70))
    pixels = draw(st.integers(1, 12))
    before, more = (np.array(draw(st.lists(some, min_size=pixels, max_size=pixels)), np.uint32) for _ in range(2))
    left = [draw(st.integers(0, int(each))) if draw(st.booleans()) else int(each) for each in more]
    return Stretch(0, before, before + more), before + more - np.array(left, np.uint32)


@given(begun_rounds(), st.integers(1, 50))
def test_what_is_missing_is_drawn_once_and_in_the_packets_of_the_round(begun, size):
    stretch, drawn = begun
    whole = packets(traced(Line(stretch), 1 << 20))
    found = traced(Line(stretch, drawn), size)
    expected = [(k, s) for k in range(len(drawn)) for s in range(drawn[k], stretch.after[k])]
    assert added(found) == expected
    assert len(set(found)) == len(found)
    now = packets(found)
    assert all(now[sample] == whole[sample] for sample in expected)


@given(begun_rounds(), st.data())
def test_parts_draw_what_the_whole_draws(begun, data):
    stretch, drawn = begun
    pixels = len(drawn)
    whole = packets(traced(Line(stretch), 1 << 20))
    first = data.draw(st.integers(0, pixels - 1))
    size = data.draw(st.integers(1, pixels - first))
    inside = slice(first, first + size)
    expected = [(k, s) for k in range(first, first + size) for s in range(drawn[k], stretch.after[k])]
    if not expected:
        return
    part = stretch.part(first, size)
    there = part.after.copy()
    there[first - part.first_pixel :][:size] = drawn[inside]
    found = traced(Line(part, there, first), 1 << 20, first)
    assert added(found) == expected
    now = packets(found)
    assert all(now[sample] == whole[sample] for sample in expected)
    again = part.part(first, size)
    assert np.array_equal(again.before, part.before)
    assert np.array_equal(again.after, part.after)


def test_little_is_traced_beside_what_is_missing():
    after = np.full(1000, 100, np.uint32)
    drawn = after.copy()
    drawn[[10, 500]] -= 3
    assert Line(Stretch(0, 0 * after, after), drawn).total <= 4 * PACKET
    assert Line(Stretch(0, 0 * after, after), after).total == 0


def test_no_pixel_is_drawn_twice_between_windows():
    counts = np.array([0, 25, 0, 0, 37, 1, 0], np.uint32)
    first = np.array([2, 10, 0, 0, 100, 0, 0], np.uint32)
    drawn = []
    for window in Line(Stretch(0, first, first + counts)).passes(4):
        pixel, index = lane_pixels(window)
        drawn += zip(np.array(pixel).tolist(), np.array(index).tolist(), strict=True)
    expected = [(1, 10 + k) for k in range(25)] + [(4, 100 + k) for k in range(37)] + [(5, 0)]
    assert drawn == expected


def test_what_is_traced_beside_others_is_not_added():
    """Of 20 samples a pixel three have 5 left each: their packets hold samples that there are."""
    after = np.full(6, 20, np.uint32)
    drawn = after.copy()
    drawn[[1, 2, 4]] = 15
    window = Line(Stretch(0, 0 * after, after), drawn).take(1000)
    assert window.sample_count == 15 < window.lane_count
    begin, end = (lanes.numpy().astype(int) for lanes in window.lanes_of(0, 6))
    assert (end - begin).tolist() == [0, 5, 5, 0, 5, 0]
    pixel, index = lane_pixels(window)
    added = [lane for first, last in zip(begin, end, strict=True) for lane in range(first, last)]
    assert np.array_equal(pixel.numpy()[added], np.repeat([1, 2, 4], 5))
    assert np.array_equal(index.numpy()[added], np.tile(np.arange(15, 20), 3))


def test_lines_longer_than_32_bits():
    counts = np.array([2**31, 2**31, 7, 2**31], np.uint32)
    first = np.array([0, 5, 0, 0], np.uint32)
    line = Line(Stretch(0, first, first + counts))
    line.taken = 2**32 - 16
    window = line.take(32)
    assert line.total == 3 * 2**31 + 7
    pixel, index = lane_pixels(window)
    assert np.array(pixel).tolist() == [1] * 16 + [2] * 7 + [3] * 9
    assert np.array(index).tolist() == [*range(2**31 - 11, 2**31 + 5), *range(7), *range(9)]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_the_size_of_passes_changes_no_bit_where_rays_meet_two_surfaces(seed):
    """In this room edges of boxes meet walls: without packets of the round 1 to 5 of 65 536 pixels differ."""
    found = []
    with open_scene(files("tracer.scenes") / "window_interior.xml", size=(256, 256)) as view:
        counts = np.full(view.grid, 16, np.uint32)
        for size in (1 << 20, 70_001):
            drawer = LocalDrawer(view, None, largest_pass=size)
            estimate = drawer.empty()
            for _ in drawer.draw(estimate, 0 * counts, counts, seed, 0.25):
                pass
            found.append(estimate.state())
            drawer.close()
    for one, other in zip(*found, strict=True):
        assert np.array_equal(one, other)
