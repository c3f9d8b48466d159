"""What paths show of errors, against values from analysis."""

import numpy as np
import pytest

from tracer.guiding.evidence import Evidence, block_errors, brightness, path_noise
from tracer.guiding.training import Paths, Trials, trained_pixels

PIXELS = 4000


def nothing_tried():
    nothing = np.zeros((0, 3))
    return Trials(np.zeros(0, np.uint32), nothing, nothing, np.zeros(0, np.uint32), np.zeros(0), np.zeros(0))


def paths_of(radiance, block):
    return Paths(trained_pixels(PIXELS, radiance.size, block)[0], radiance, block)


def seen(radiance, block=4):
    return Evidence.of(paths_of(radiance, block), nothing_tried(), (50, 80), "absolute", 0.0)


def test_errors_of_blocks_are_variances_of_their_means():
    block, size = 4, 8 * PIXELS
    paths = paths_of(np.random.default_rng(1).normal(2, 0.5, size), block)
    weight = np.full(size, 3.0)
    assert path_noise(paths, weight).mean() == pytest.approx(3 * 0.25, rel=0.05)
    assert block_errors(paths, weight).mean() == pytest.approx(3 * 0.25 / block, rel=0.1)


def test_pixels_have_two_blocks_and_more_paths_have_the_same_pixels():
    pixel, sequence, index = trained_pixels(1000, 640, 8)
    assert pixel.size == 640
    assert np.all(pixel.reshape(-1, 16) == pixel[::16, None])
    assert sequence[:16].tolist() == [0] * 8 + [1] * 8
    assert index[:16].tolist() == [*range(8), *range(8)]
    assert np.array_equal(trained_pixels(1000, 3 * 640, 8)[0][::16][::3], pixel[::16])


def test_few_pixels_come_again_with_other_samples():
    chosen = trained_pixels(10, 1600, 8)
    assert len(set(zip(*(values.tolist() for values in chosen), strict=True))) == 1600
    assert np.bincount(chosen[0]).tolist() == [160] * 10


def test_what_is_left_of_the_error_is_measured_with_its_doubt():
    random = np.random.default_rng(2)
    ratios, doubts = [], []
    for _ in range(40):
        before, after = (seen(random.normal(2, size, 8 * 500)) for size in (0.5, 0.25))
        left, doubt = after.after(before).error_left()
        ratios.append(left)
        doubts.append(doubt)
    assert np.mean(ratios) == pytest.approx(0.25, rel=0.1)
    assert np.std(ratios) / np.mean(ratios) == pytest.approx(np.mean(doubts), rel=0.35)


def test_more_paths_are_compared_where_the_first_were():
    """Every third pixel of the last training is one of the first: only these have a smaller error here."""
    random = np.random.default_rng(3)
    size = np.where(np.arange(1500) % 3 == 0, 0.1, 5.0)
    before = seen(random.normal(2, 0.5, 8 * 500))
    after = seen(random.normal(2, 1, 8 * 1500) * np.repeat(size, 8))
    assert after.after(before).error_left()[0] == pytest.approx(0.04, rel=0.4)


def test_pictures_without_light_have_nothing_left_to_learn():
    dark = seen(np.zeros(8 * 100))
    assert dark.after(dark).error_left() == (1.0, 0.0)


def test_brightness_is_that_of_the_square():
    radiance = np.array([1.0, 3.0, 5.0, 7.0])
    pixel = np.array([0, 7, 8, 16 * 8])  # in pictures 16 wide: one square of 8 x 8, the one beside it, the one below
    assert brightness(pixel, radiance, (16, 16)).tolist() == [2.0, 2.0, 5.0, 7.0]
