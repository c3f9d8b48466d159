"""What samples are taken to cost."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.core.device import upload
from tracer.sampling.work import vertices_of, work_of


@pytest.mark.parametrize("size", [1, 15, 16, 40])
def test_every_lane_pays_for_its_own_path_and_for_the_longest_of_its_packet(size):
    vertices = np.random.default_rng(size).integers(1, 30, size).astype(np.float32)
    found = work_of(upload(mi.Float, vertices)).numpy()
    expected = []
    for lane in range(size):
        longest = vertices[lane // 16 * 16 : lane // 16 * 16 + 16].max()
        later = max(longest - 2, 0) + 5 * max(vertices[lane] - 2, 0)
        expected.append(1 + (1 if longest > 1 else 0) + later)
    assert found.tolist() == expected


def test_the_unit_is_a_ray_that_meets_nothing():
    assert np.all(work_of(mi.Float([1.0] * 16)).numpy() == 1)
    assert np.all(work_of(mi.Float([1.0] * 15 + [2.0])).numpy() == 2)


def test_path_draws_four_numbers_at_a_vertex_and_others_may_draw_none():
    assert vertices_of(mi.UInt32([0, 2, 4, 8, 20])).numpy().tolist() == [1, 1, 1, 2, 5]
