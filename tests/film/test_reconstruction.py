"""Standard errors of the image: the variance that they come from, and unusual filters."""

import mitsuba as mi
import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from tracer.film.reconstruction import Rows, filtered, shrunken_variance
from tracer.scene.frame import PlainFrame


def test_a_negative_sum_of_weights_leaves_standard_errors_positive():
    """As filters with negative lobes have it where few samples are in reach."""
    frame = PlainFrame((1, 2), 0, ["Y"], 1, (0, 0, 2, 1))
    footprints = np.zeros((2, 9, 2), np.float32)
    footprints[:, 4] = [[2, -0.5], [3, 2]]  # sums of weight x value and of weight that pixels give to themselves
    padding = np.zeros((2, 2), np.float32)
    rows = Rows(mi.Float(np.hstack([footprints.reshape(2, 18), padding]).ravel()), 20)
    known = Rows.of([mi.Float([1, 1]), mi.Float([4, 9])])
    values, errors = filtered(rows, 0, mi.UInt32([0, 1]), known, frame)
    assert np.array(values).tolist() == [[-4, 1.5]]
    assert np.array(errors).tolist() == [[2, 3]]


def test_shrunken_variance_is_that_of_scipy():
    rng = np.random.default_rng(1)
    count = rng.integers(0, 9, (10, 13)).astype(np.float64)
    degrees = np.maximum(count - 1, 0)
    deviation = degrees * rng.exponential(size=count.shape)
    around = uniform_filter(deviation, 7, mode="nearest") / uniform_filter(degrees, 7, mode="nearest")
    expected = (16 * around + deviation) / (16 + degrees)
    (found,) = shrunken_variance([mi.Float64(deviation.ravel())], mi.Float64(count.ravel()), count.shape)
    assert np.array(found).reshape(count.shape) == pytest.approx(expected, rel=1e-5)


def test_nothing_is_known_of_single_samples():
    (found,) = shrunken_variance([mi.Float64(np.zeros(12))], mi.Float64(np.ones(12)), (3, 4))
    assert np.all(np.array(found) == 0)


def test_rows_give_back_their_columns():
    columns = [mi.Float([k, k + 0.5, k + 0.25]) for k in range(6)]
    rows = Rows.of(columns)
    for begin, count in ((0, 6), (0, 3), (3, 3), (5, 1)):
        found = rows.entries(mi.UInt32([2, 0]), begin, count, True)
        assert np.array(found).tolist() == [[k + 0.25, k] for k in range(begin, begin + count)]
