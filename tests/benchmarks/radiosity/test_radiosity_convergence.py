"""Gains over even rays, and time that is compared."""

import numpy as np
import pytest

from benchmarks.radiosity import convergence
from benchmarks.radiosity.convergence import METHODS, Curve, gains_over_even, gathered, in_as_much_time, prepare
from benchmarks.radiosity.scenes import Example, chandelier, load


def curve(method, rays, seconds, error):
    return Curve("a", method, rays, [error * (1 + 0.01 * k) for k in range(convergence.SEEDS)], seconds, rays, 1.0)


def test_time_is_compared_along_the_line_of_even_rays():
    curves = [curve("evenly", 64, 1.0, 0.16), curve("evenly", 256, 4.0, 0.01)]
    assert in_as_much_time(curves, curve("other", 256, 8.0, 1.0))[0] == pytest.approx(0.0025)
    assert in_as_much_time(curves, curve("other", 64, 0.5, 1.0))[0] == pytest.approx(0.64)
    assert in_as_much_time(curves, curve("other", 64, 1.0, 1.0)) == pytest.approx(curves[0].errors)
    found = gains_over_even([*curves, curve("deviation, warp", 256, 8.0, 0.005)])
    assert found[0]["equal_rays"][0] == pytest.approx(2)
    assert found[0]["equal_time"][0] == pytest.approx(0.5)


@pytest.mark.slow
def test_every_method_finds_what_is_true():
    place = prepare(Example("small", "", load(chandelier()), 2.0, True))
    mean = place.truth.mean()
    for method in METHODS:
        results = [gathered(place, method, 512, seed) for seed in range(3)]
        assert np.mean([result.irradiance for result in results]) == pytest.approx(mean, rel=0.05)
        assert results[0].rays == pytest.approx(512, rel=0.05)
