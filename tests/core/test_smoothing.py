"""Means over neighbours, beside those of SciPy."""

import mitsuba as mi
import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, uniform_filter

from tracer.core.device import to_host, upload
from tracer.core.smoothing import box, gaussian, smoothed

SIZES = [(1, 1), (1, 9), (7, 1), (20, 33)]


def picture(size):
    return np.random.default_rng(1).random(size).astype(np.float32)


@pytest.mark.parametrize("size", SIZES, ids=str)
@pytest.mark.parametrize("beyond", ["nearest", "mirror"])
def test_pictures_are_smoothed_as_scipy_does_it(size, beyond):
    values = picture(size)
    kernels = gaussian(0.5), box(13), gaussian(1.0), box(3)
    expected = [
        gaussian_filter(values, 0.5, mode=beyond),
        uniform_filter(values, 13, mode=beyond),
        gaussian_filter(values, 1.0, mode=beyond),
        uniform_filter(values, 3, mode=beyond),
    ]
    for found, other in zip(smoothed(upload(mi.Float, values), size, *kernels, beyond=beyond), expected, strict=True):
        assert to_host(found, size) == pytest.approx(other, rel=1e-5, abs=1e-6)


def test_beyond_the_second_mirror_image_of_a_small_picture_is_its_edge():
    (found,) = smoothed(mi.Float([1, 2]), (1, 2), box(9), beyond="mirror")
    assert found.numpy()[0] == pytest.approx(np.mean([1, 1, 1, 2, 1, 2, 1, 1, 1]))


@pytest.mark.parametrize("kernel", [box(1), box(7), gaussian(0.5), gaussian(2.0)])
def test_a_constant_stays(kernel):
    (found,) = smoothed(upload(mi.Float, np.full((6, 8), 3.0)), (6, 8), kernel)
    assert found.numpy() == pytest.approx(3.0, rel=1e-6)
