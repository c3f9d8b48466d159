"""A mixture of a noisy and a denoised picture is not worse than the better of the two, but for a little."""

import numpy as np
import pytest

from tracer.denoising.blend import blend, errors_of, share_of_noisy

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
    found = blend(noisy, clean, errors_of(clean, stderr, own_of(stderr), 1.0))
    errors = [np.mean((each - truth) ** 2) for each in (noisy, clean, found)]
    assert errors[2] <= 1.15 * min(errors[:2]) + 0.02 * noise**2


def test_half_and_half_where_both_are_as_bad():
    truth, noisy, clean = pictures(0.05, 0.05)
    stderr = np.full(SHAPE, 0.05)
    found = blend(noisy, clean, errors_of(clean, stderr, own_of(stderr), 1.0))
    assert np.mean((found - truth) ** 2) == pytest.approx(0.05**2 / 2, rel=0.1)


def test_a_firefly_does_not_come_back():
    truth, noisy, clean = pictures(0.01, 0.0)
    noisy[40, 50] += 20.0
    stderr = np.full(SHAPE, 0.01)
    own = own_of(stderr)
    own[40, 50] = 20.0**2  # the pixel's own samples know it, its neighbours do not
    found = blend(noisy, clean, errors_of(clean, stderr, own, 1.0))
    assert abs(found - truth).max() < 0.05


def test_errors_that_were_measured_count():
    """Standard errors say three times what is true; measured, the noisy picture is seen to be the better one."""
    truth, noisy, clean = pictures(0.001, 0.004)
    stderr = np.full(SHAPE, 0.003)
    plain, measured = (blend(noisy, clean, errors_of(clean, stderr, own_of(stderr), scale)) for scale in (1.0, 0.4))
    errors = [np.mean((each - truth) ** 2) for each in (plain, measured)]
    assert errors[1] < 0.4 * errors[0]


def test_a_single_pixel_far_beyond_the_noise_is_believed():
    truth, noisy, clean = pictures(0.01, 0.0)
    truth[40, 50] = noisy[40, 50] = 3.0
    stderr = np.full(SHAPE, 0.01)
    found = blend(noisy, clean, errors_of(clean, stderr, own_of(stderr), 1.0))
    assert found[40, 50] == pytest.approx(3.0, rel=0.01)
    assert np.mean((found[:30] - truth[:30]) ** 2) < 0.1 * 0.01**2


def test_errors_far_above_what_pictures_are_apart_by_are_not_believed():
    """Errors are said to be thirty times as large as they are: what a few pixels have lost is seen all the same."""
    truth, noisy, clean = pictures(0.001, 0.0)
    lost = np.random.default_rng(4).random(SHAPE[:2]) < 0.05
    clean[lost] += 0.02
    stderr = np.full(SHAPE, 0.03)
    errors = errors_of(clean, stderr, own_of(stderr), 0.2, certain=np.ones(SHAPE[:2], bool))
    found = blend(noisy, clean, errors)
    assert np.mean((found - truth)[lost] ** 2) < 0.1 * 0.02**2


def test_pixels_that_tell_nothing_of_their_neighbours_do_not_count_around():
    truth, noisy, clean = pictures(0.01, 0.0)
    clean[40:50, 50:60] += 5.0
    telling = np.ones(SHAPE[:2], bool)
    telling[40:50, 50:60] = False
    stderr = np.full(SHAPE, 0.01)
    errors = errors_of(truth, stderr, own_of(stderr), 1.0, telling=telling)
    share = share_of_noisy(noisy - clean, errors)[..., 0]
    assert share[telling].mean() < 0.1
    assert share[~telling].min() > 0.99
