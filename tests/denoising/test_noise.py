"""What noise may be: the samples' own errors, their surroundings after few samples, and less the more samples."""

import numpy as np
import pytest

from tracer.denoising.noise import edge_share, expected_noise, own_errors, possible_ratio

SIZE = (24, 32)


def flat(value):
    return np.full(SIZE, value, np.float32)


def test_own_errors_are_variance_over_count_and_a_single_sample_knows_nothing():
    mean, variance = np.full((2, 2, 3), 3.0, np.float32), np.full((2, 2, 3), 8.0, np.float32)
    count = np.array([[4, 1], [2, 0]], np.float32)
    expected = [[[2.0] * 3, [9.0] * 3], [[4.0] * 3, [9.0] * 3]]
    assert own_errors(mean, variance, count) == pytest.approx(np.array(expected))


@pytest.mark.parametrize("count", [1.0, 8.0, 1000.0])
def test_even_noise_is_what_it_is(count):
    assert expected_noise(flat(0.5), flat(0.5), flat(0.01), flat(count), 0.5) == pytest.approx(flat(0.01))


def test_after_few_samples_surroundings_tell_of_noise_that_a_pixel_has_not_seen():
    own = flat(0.01)
    own[10, 10] = 0.0
    found = [expected_noise(flat(0.5), flat(0.5), own, flat(count), 0.5)[10, 10] for count in (4.0, 32.0, 512.0)]
    assert found == pytest.approx([0.01 * 48 / 49 * (32 / (32 + n)) ** 2 for n in (4, 32, 512)], rel=1e-3)


def test_a_lamp_leaves_its_surroundings_alone():
    """Beside a lamp a million times as bright, noise counts in proportion to brightness."""
    grey, own = flat(1.0), flat(1e-4)
    grey[10, 10], own[10, 10] = 1e6, 1e10
    found = expected_noise(grey, grey, own, flat(8.0), 1.0)
    assert found[10, 10] == pytest.approx(1e10)
    assert found[10, 12] < 1e-3


def test_the_variance_of_an_edge_is_told_from_noise():
    clean = flat(0.0)
    clean[:, 16:] = 1.0
    of_edge = edge_share(clean, flat(0.25 / 64), flat(64.0))  # samples on both sides: variance 1/4
    assert of_edge[:, [15, 16]] == pytest.approx(8 / 9)  # 2/9 between the pixels of a square
    assert of_edge[:, :15].max() == 0.0
    assert edge_share(clean, flat(25.0 / 64), flat(64.0)).max() < 0.01


def test_the_more_samples_the_less_may_be_noise_and_least_at_edges():
    inside, at_edge = ([float(possible_ratio(flat(n), flat(e))[5, 5]) for n in (8, 32, 128)] for e in (0.0, 1.0))
    assert inside == pytest.approx([3.0, 3.0 * 4**-0.4, 3.0 * 16**-0.4], rel=1e-5)
    assert at_edge == pytest.approx([0.6, 0.6 * 4**-0.9, 0.6 * 16**-0.9], rel=1e-5)
