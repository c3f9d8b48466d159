"""What a denoiser took away is given back where it is more than noise, and only there."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.denoising.trust import PRIOR_ERROR, kept_share

SIZE = (40, 60)


def flat(value):
    return np.full(SIZE, value, np.float32)


def noise_of(deviation, seed=0):
    return (deviation * np.random.default_rng(seed).normal(size=(*SIZE, 3))).astype(np.float32)


def test_noise_is_taken():
    share = kept_share(noise_of(0.1), flat(0.01), flat(2.0), flat(8.0), flat(0.0))
    assert share == pytest.approx(flat(PRIOR_ERROR / (1 + PRIOR_ERROR)), abs=1e-5)


@pytest.mark.parametrize(("brightness", "share"), [(0.1, 0.0), (1.0, 0.01), (10.0, 0.5), (100.0, 0.99)])
def test_noise_that_nobody_sees_is_left(brightness, share):
    left = kept_share(noise_of(0.1), flat(0.01), flat(2.0), flat(8.0), flat(brightness))
    assert left == pytest.approx(flat(share), abs=PRIOR_ERROR)


@pytest.mark.parametrize("times", [3.0, 10.0])
def test_what_is_more_than_noise_is_given_back(times):
    share = kept_share(noise_of(0.1 * times), flat(0.01), flat(1.0), flat(8.0), flat(0.0))
    assert share.mean() == pytest.approx(1 - times**-3 / (1 + PRIOR_ERROR), abs=0.02)


def test_a_single_pixel_is_believed_and_its_neighbours_are_not():
    residual = noise_of(0.1)
    residual[20, 30] = 3.0  # thirty standard deviations
    share = kept_share(residual, flat(0.01), flat(2.5), flat(8.0), flat(0.0))
    assert share[20, 30] > 0.97
    share[20, 30] = 0.0
    assert share.mean() < 0.08


def test_a_firefly_is_no_more_than_its_own_error():
    residual, noise = noise_of(0.1), flat(0.01)
    residual[20, 30], noise[20, 30] = 20.0, 20.0**2
    assert kept_share(residual, noise, flat(2.0), flat(8.0), flat(0.0)).max() < 0.06


@given(
    deviation=st.floats(0, 1e6, width=32),
    noise=st.floats(0, 1e6, width=32),
    count=st.floats(0, 2**24, width=32),
    ratio=st.floats(2**-10, 10, width=32),
    brightness=st.floats(0, 2**50, width=32),
)
def test_it_is_a_share_whatever_comes(deviation, noise, count, ratio, brightness):
    known = (flat(value)[:9, :8] for value in (noise, ratio, count, brightness))
    share = kept_share(noise_of(deviation)[:9, :8], *known)
    assert share.min() >= 0.0
    assert share.max() <= 1.0
