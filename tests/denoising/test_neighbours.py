"""Small filters are those of SciPy."""

import numpy as np
import pytest
from scipy.ndimage import correlate1d, generic_filter, maximum_filter, minimum_filter

from tracer.denoising.neighbours import blurred, extreme, local_variance

SHAPES = [(1, 1), (1, 7), (5, 2), (20, 30)]


def picture(shape):
    return np.random.default_rng(1).normal(size=shape).astype(np.float32)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("tap", "repeats"), [(0.1, 1), (-0.05, 1), (0.25, 3)])
def test_blurs(shape, tap, repeats):
    image = picture((*shape, 3))
    expected = image
    for axis in (0, 1) * repeats:
        expected = correlate1d(expected, [tap, 1 - 2 * tap, tap], axis=axis, mode="nearest")
    assert blurred(image, tap, repeats) == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("side", [1, 3, 5])
def test_extrema(shape, side):
    image = picture(shape)
    assert np.array_equal(extreme(image, side, np.maximum), maximum_filter(image, side, mode="nearest"))
    assert np.array_equal(extreme(image, side, np.minimum), minimum_filter(image, side, mode="nearest"))


@pytest.mark.parametrize("shape", SHAPES)
def test_variances(shape):
    image = picture(shape)
    assert local_variance(image) == pytest.approx(generic_filter(image, np.var, 3, mode="nearest"), abs=1e-5)


def test_a_lamp_far_away_does_not_matter():
    image = picture((9, 40)) * 1e-3
    expected = local_variance(image)[:, 10:]
    image[:, 5] = 1e9
    assert np.array_equal(local_variance(image)[:, 10:], expected)
