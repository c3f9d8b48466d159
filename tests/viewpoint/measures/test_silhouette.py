"""Outlines of shapes whose length and turns are known."""

import numpy as np
import pytest

from tracer.viewpoint.measures import get
from tracer.viewpoint.observation import Picture, Sight


def sight(mask):
    depth = np.where(mask, 0.5, np.nan).astype(np.float32)
    return Sight(None, np.array([0]), np.array([1.0]), 1.0, picture=Picture(mask, depth))


def measured(mask):
    names = ("length", "entropy", "curvature", "curvature_extrema")
    return [get(f"silhouette_{name}").value(sight(mask)) for name in names]


def block(size, side=64):
    mask = np.zeros((side, side), bool)
    mask[8 : 8 + size, 8 : 8 + size] = True
    return mask


def test_a_square_turns_eight_times_by_half_a_right_angle():
    length, entropy, curvature, extrema = measured(block(20))
    steps = 4 * 19 + 4  # its corners are cut
    assert length == pytest.approx((4 * 19 + 4 * np.sqrt(0.5)) / 64)
    p = 8 / steps
    assert entropy == pytest.approx(-p * np.log2(p) - (1 - p) * np.log2(1 - p))
    assert curvature == pytest.approx(p / 2)
    assert extrema == pytest.approx(p / 4)


def test_holes_and_parts_have_outlines_too():
    mask = block(40)
    whole = measured(mask)[0]
    mask[20:30, 20:30] = False
    assert measured(mask)[0] == pytest.approx(whole + (4 * 9 + 4 * (0.5 + 0.5) * np.sqrt(2)) / 64, rel=0.05)


def test_a_picture_that_is_full_has_its_frame_as_outline():
    full = np.ones((32, 32), bool)
    assert measured(full)[0] == pytest.approx((4 * 31 + 4 * np.sqrt(0.5)) / 32)


def test_nothing_has_no_outline():
    assert measured(np.zeros((16, 16), bool)) == [0, 0, 0, 0]


def test_a_jagged_outline_is_longer_and_turns_more():
    plain, jagged = block(32), block(32)
    jagged[8:40:2, 7] = True
    assert np.all(np.array(measured(jagged)) > np.array(measured(plain)))
