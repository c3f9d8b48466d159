"""Gains and their intervals, and time that is compared."""

import numpy as np
import pytest

from benchmarks.radiosity import convergence
from benchmarks.radiosity.convergence import METHODS, Curve, gain, in_as_much_time, once, prepare, rows
from benchmarks.radiosity.scenes import Example, chandelier, load


def curve(method, rays, seconds, error):
    return Curve("a", method, rays, [error * (1 + 0.01 * k) for k in range(convergence.SEEDS)], seconds, rays, 1.0)


def test_gain_of_errors_that_are_half():
    middle, least, most = gain([1.0, 2.0, 3.0], [2.0, 4.0, 6.0])
    assert (middle, least, most) == pytest.approx((2, 2, 2))
    middle, least, most = gain([1.0, 1.0, 1.0], [1.0, 2.0, 4.0])
    # Student: 4.303 standard errors of the logarithm for three seeds.
    reach = 4.303 * np.log(2) / np.sqrt(3)
    assert (middle, least, most) == pytest.approx((2, 2 / np.exp(reach), 2 * np.exp(reach)), rel=1e-3)


def test_time_is_compared_along_the_line_of_even_rays():
    curves = [curve("evenly", 64, 1.0, 0.16), curve("evenly", 256, 4.0, 0.01)]
    assert in_as_much_time(curves, curve("other", 256, 8.0, 1.0))[0] == pytest.approx(0.0025)
    assert in_as_much_time(curves, curve("other", 64, 0.5, 1.0))[0] == pytest.approx(0.64)
    assert in_as_much_time(curves, curve("other", 64, 1.0, 1.0)) == pytest.approx(curves[0].errors)
    found = rows([*curves, curve("deviation, warp", 256, 8.0, 0.005)])
    assert found[0]["equal_rays"][0] == pytest.approx(2)
    assert found[0]["equal_time"][0] == pytest.approx(0.5)


@pytest.mark.slow
def test_every_method_finds_what_is_true():
    place = prepare(Example("small", "", load(chandelier()), 2.0, True))
    mean = place.truth.mean()
    for method in METHODS:
        found = [once(place, method, 512, seed) for seed in range(3)]
        assert np.mean([each[0] for each in found]) == pytest.approx(mean, rel=0.05)
        assert found[0][1] == pytest.approx(512, rel=0.05)
