"""Weights of the errors: their definitions, at every exposure."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.image import objective
from tracer.image.colour import encode_srgb


def test_absolute_and_relative():
    assert objective.weights("absolute", [0, 1, 5]) == pytest.approx([1, 1, 1])
    assert objective.weights("relative", [0, 1]) == pytest.approx([100, 1 / 1.01])


def test_display_is_the_squared_slope_of_the_curve_and_zero_where_it_clips():
    luminance = np.array([0.001, 0.1, 0.5, 0.9])
    step = 1e-6
    slope = (encode_srgb(luminance + step) - encode_srgb(luminance - step)) / (2 * step)
    assert objective.weights("display", luminance) == pytest.approx(slope**2, rel=1e-4)
    assert objective.weights("display", [1.0, 20.0]) == pytest.approx([0, 0])


ERRORS = {  # of a pixel that is seen as ``shown`` where ``right`` would be, by their definitions
    "absolute": lambda shown, right: shown - right,
    "relative": lambda shown, right: (shown - right) / np.sqrt(right**2 + 0.01),
    "display": lambda shown, right: encode_srgb(shown) - encode_srgb(right),
}


@pytest.mark.parametrize("name", objective.OBJECTIVES)
@pytest.mark.parametrize("exposure", [-3.0, 0.0, 3.0, 13.29])
def test_a_weight_is_the_squared_error_of_the_exposed_picture_over_that_of_the_radiance(name, exposure):
    luminance = np.array([0.001, 0.1, 0.4, 0.9, 3.0]) / 2**exposure
    step = 1e-6 * luminance
    error = ERRORS[name]((luminance + step) * 2**exposure, luminance * 2**exposure)
    assert objective.weights(name, luminance, exposure) == pytest.approx((error / step) ** 2, rel=1e-4)


@given(st.sampled_from(objective.OBJECTIVES), st.floats(1e-6, 1e3), st.integers(-20, 20), st.floats(-5, 5))
def test_half_the_light_at_one_stop_more_is_the_same_error(name, luminance, stops, exposure):
    bright = objective.weights(name, [luminance], exposure)
    dark = objective.weights(name, [luminance * 2.0**-stops], exposure + stops)
    assert dark * 4.0**-stops == pytest.approx(bright, rel=1e-9)


@given(st.lists(st.floats(0, 1e300), min_size=1), st.integers(-900, 0))
def test_shares_do_not_see_a_scale_and_fit_float32(values, exponent):
    weights = np.ldexp(np.array(values), exponent)
    scaled = objective.without_scale(weights)
    assert np.all(np.isfinite(scaled.astype(np.float32)))
    if weights.max() > 1e-300:
        assert 0.5 <= scaled.max() < 1
        assert np.outer(scaled, weights) == pytest.approx(np.outer(weights, scaled), rel=1e-12)


def test_negative_luminance_is_black():
    assert objective.weights("relative", [-3.0]) == pytest.approx(objective.weights("relative", [0.0]))


def test_unknown_objective():
    with pytest.raises(ValueError, match="unknown objective 'nicer'"):
        objective.weights("nicer", [1])
