"""Weights of the three errors."""

import numpy as np
import pytest

from tracer import objective
from tracer.score import encode_srgb


def test_absolute_and_relative():
    assert objective.weights("absolute", [0, 1, 5]) == pytest.approx([1, 1, 1])
    assert objective.weights("relative", [0, 1]) == pytest.approx([100, 1 / 1.01])


def test_display_is_the_squared_slope_of_the_curve_and_zero_where_it_clips():
    luminance = np.array([0.001, 0.1, 0.5, 0.9])
    step = 1e-6
    slope = (encode_srgb(luminance + step) - encode_srgb(luminance - step)) / (2 * step)
    assert objective.weights("display", luminance) == pytest.approx(slope**2, rel=1e-4)
    assert objective.weights("display", [1.0, 20.0]) == pytest.approx([0, 0])


@pytest.mark.parametrize("name", objective.OBJECTIVES)
def test_exposure_brightens_before_anything_else(name):
    luminance = np.array([0.001, 0.1, 0.4, 3.0])
    assert objective.weights(name, luminance, 2.0) == pytest.approx(objective.weights(name, 4 * luminance))


def test_negative_luminance_is_black():
    assert objective.weights("relative", [-3.0]) == pytest.approx(objective.weights("relative", [0.0]))


def test_unknown_objective():
    with pytest.raises(ValueError, match="unknown objective 'nicer'"):
        objective.weights("nicer", [1])
