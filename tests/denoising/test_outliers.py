"""Lamps stand out of a picture, and stay as they were; fireflies, noise and large bright things do not."""

import numpy as np
import pytest

from tracer.denoising.outliers import find_outliers, own_errors, taken_out, within_reach

SIZE = (60, 80)
SAMPLES = 64


def drawn(probability, value, background=0.3, seed=0):
    """Return mean, squared errors and counts of pixels, a sample of which sees ``value`` with a probability (H, W)."""
    random = np.random.default_rng(seed)
    seen = random.random((SAMPLES, *SIZE)) < probability
    samples = np.where(seen, value, background * random.exponential(size=seen.shape))
    mean, variance = (np.repeat(each[..., None], 3, axis=-1) for each in (samples.mean(0), samples.var(0, ddof=1)))
    count = np.full(SIZE, SAMPLES)
    return mean, own_errors(mean, variance, count), count


def lamp(height, width, coverage=1.0):
    probability = np.zeros(SIZE)
    probability[20 : 20 + height, 30 : 30 + width] = coverage
    return probability


@pytest.mark.parametrize("value", [1e2, 1e4, 1e6])
@pytest.mark.parametrize(("height", "width"), [(1, 1), (2, 2), (4, 4), (1, 25), (8, 8)])
def test_small_lamps_stand_out_and_nothing_else(height, width, value):
    mean, own, count = drawn(lamp(height, width), value)
    outliers = find_outliers(mean, own, count)
    assert np.array_equal(outliers.mask, lamp(height, width) > 0)
    calm = taken_out(mean, outliers)
    assert calm.max() < 1.0
    assert np.array_equal(calm[~outliers.mask], mean[~outliers.mask])


def test_the_edge_that_few_samples_see_belongs_to_its_lamp():
    probability = lamp(3, 3)
    probability[19, 30:33] = 2 / SAMPLES
    mean, own, count = drawn(probability, 1e4, seed=3)
    mask = find_outliers(mean, own, count).mask
    assert mask[19, 30:33].sum() == (mean[19, 30:33, 0] > 100).sum() > 0


@pytest.mark.parametrize("probability", [1e-4, 1e-3, 1e-2])
def test_light_that_few_samples_find_does_not_stand_out(probability):
    """Of 4,800 pixels fewer than 5 in expectation have the three samples that it takes: P(> 15) < 1e-4."""
    mean, own, count = drawn(np.full(SIZE, probability), 1e4)
    assert find_outliers(mean, own, count).mask.sum() <= 15


def test_noise_and_large_bright_things_do_not_stand_out():
    for probability in (np.zeros(SIZE), lamp(30, 40)):
        assert not find_outliers(*drawn(probability, 1e4)).mask.any()


def test_one_sample_knows_nothing():
    mean = np.full((*SIZE, 3), 0.3)
    mean[20, 30] = 1e4
    count = np.ones(SIZE, int)
    own = own_errors(mean, 0 * mean, count)
    assert np.array_equal(own, mean**2)
    assert not find_outliers(mean, own, count).mask.any()


@pytest.mark.parametrize("reach", [0, 1, 2])
def test_what_is_in_reach_stays(reach):
    mean, own, count = drawn(lamp(2, 2), 1e4)
    stays = within_reach(mean, mean, find_outliers(mean, own, count), reach)
    beside = reach + 1  # a denoiser could bleed there
    expected = np.zeros(SIZE, bool)
    expected[20 - beside : 22 + beside, 30 - beside : 32 + beside] = True
    assert np.array_equal(stays, expected)


def test_beside_a_large_lamp_pixels_stay():
    mean, own, count = drawn(lamp(30, 40), 1e4)
    stays = within_reach(mean, mean, find_outliers(mean, own, count), 1)
    assert stays[18:20, 30:70].all()
    assert not stays[:17].any()
    assert not stays[22:48, 32:68].any()
