"""Sums survive being packed, sent and cut."""

import pickle

import numpy as np
from dask.sizeof import sizeof

from tracer.cluster.sums import TRASH, Sums, by_source, cut, pack, packed, write
from tracer.cluster.work_balancer import Region
from tracer.film.estimate import Estimate
from tracer.scene.frame import PlainFrame


def frame(width, reach=1):
    return PlainFrame((1, width), 0, ["R", "G", "B"], reach, (0, 0, width, 1))


def filled(width):
    estimate = Estimate(frame(width), 1, 1)
    layout, *arrays = estimate.state()
    rng = np.random.default_rng(3)
    estimate.restore([layout, *(rng.integers(0, 99, each.shape).astype(each.dtype) for each in arrays)])
    return estimate


def same(one, other):
    return all(np.array_equal(a, b) for a, b in zip(one.state(), other.state(), strict=True))


def test_sums_are_cut_out_of_packed_ones():
    arrays = [np.arange(7, dtype=np.uint32), np.arange(7) / 3, np.arange(14, dtype=np.float32).reshape(7, 2)]
    found = cut(pack(arrays), arrays, 2, 4)
    assert all(np.array_equal(piece, array[2:6]) for piece, array in zip(found, arrays, strict=True))
    into = [np.zeros_like(each) for each in arrays]
    write(pack(arrays), Region(1, 3, skip=4), into)
    assert list(into[0]) == [0, 4, 5, 6, 0, 0, 0]


def test_another_process_gets_the_same_sums():
    estimate = filled(13)
    sums = Sums(estimate)
    sent = pickle.loads(pickle.dumps(sums))
    for one in (sums, sent):
        new = Estimate(frame(13), 1, 1)
        one.fill(new, 0)
        assert same(new, estimate)
        part = Estimate(frame(5), 1, 1)
        one.fill(part, 4)
        assert all(np.array_equal(a, b[4:9]) for a, b in zip(part.state()[1:], estimate.state()[1:], strict=True))
        one.fill(part, 0)
        assert all(np.array_equal(a, b[:5]) for a, b in zip(part.state()[1:], estimate.state()[1:], strict=True))
    assert sizeof(sums) == sizeof(sent) == len(sums.packed())


def test_sums_in_one_piece_are_fetched_at_once():
    first, second = object(), object()
    regions = [Region(0, 1, first), Region(1, 2, second), Region(3, 1), Region(4, 2, first, skip=4)]
    assert by_source(regions) == [[regions[0], regions[3]], [regions[1]]]


def test_a_part_of_the_whole_is_packed_by_its_place():
    arrays = [np.arange(9, dtype=np.uint32), np.arange(9) / 3]
    found = cut(packed(arrays, 3, 4), arrays, 0, 4)
    assert [list(each) for each in found] == [list(each[3:7]) for each in arrays]


def test_arrays_of_a_device_are_left_to_its_thread():
    TRASH.clear()
    sums = Sums(filled(3))
    strip = sums.strip
    del sums
    assert TRASH.pop()[0] is strip
