"""A mixture of a noisy and a denoised picture is not worse than the better of the two, but for a little."""

import numpy as np
import pytest

from tracer.blend import blend

SHAPE = (96, 128, 3)


def pictures(noise, blur, seed=0):
    """Return truth, a picture with normal noise, and one that is off by ``blur`` in a way that does not vary."""
    random = np.random.default_rng(seed)
    truth = np.full(SHAPE, 0.5)
    noisy = truth + noise * random.normal(size=SHAPE)
    clean = truth + blur * np.sign(random.normal(size=SHAPE))
    return truth, noisy, clean


def own_of(stderr, samples=8):
    """Return squared errors as pixels know them from their few samples."""
    return stderr**2 * np.random.default_rng(9).chisquare(samples - 1, SHAPE) / (samples - 1)


@pytest.mark.parametrize("noise", [0.001, 0.01, 0.1])
@pytest.mark.parametrize("blur", [0.0, 0.003, 0.03, 0.3])
def test_it_is_as_good_as_the_better_one(noise, blur):
    truth, noisy, clean = pictures(noise, blur)
    stderr = np.full(SHAPE, noise)
    found = blend(noisy, clean, stderr, own_of(stderr), 1.0)
    errors = [np.mean((each - truth) ** 2) for each in (noisy, clean, found)]
    assert errors[2] <= 1.15 * min(errors[:2]) + 0.02 * noise**2


def test_half_and_half_where_both_are_as_bad():
    truth, noisy, clean = pictures(0.05, 0.05)
    stderr = np.full(SHAPE, 0.05)
    found = blend(noisy, clean, stderr, own_of(stderr), 1.0)
    assert np.mean((found - truth) ** 2) == pytest.approx(0.05**2 / 2, rel=0.1)


def test_a_firefly_does_not_come_back():
    truth, noisy, clean = pictures(0.01, 0.0)
    noisy[40, 50] += 20.0
    stderr = np.full(SHAPE, 0.01)
    own = own_of(stderr)
    own[40, 50] = 20.0**2  # the pixel's own samples know it, its neighbours do not
    found = blend(noisy, clean, stderr, own, 1.0)
    assert abs(found - truth).max() < 0.05


def test_errors_that_were_measured_count():
    """Standard errors say three times what is true; measured, the noisy picture is seen to be the better one."""
    truth, noisy, clean = pictures(0.001, 0.004)
    stderr = np.full(SHAPE, 0.003)
    plain, measured = (blend(noisy, clean, stderr, own_of(stderr), scale) for scale in (1.0, 0.4))
    errors = [np.mean((each - truth) ** 2) for each in (plain, measured)]
    assert errors[1] < 0.4 * errors[0]
