"""Lamps and what is beside them stay as they were drawn; fireflies, noise and soft light do not."""

import numpy as np
import pytest

from tracer.denoising.glare import find_glare, is_certain

SIZE = (60, 80)
SAMPLES = 64


def drawn(probability, value, background=0.3, seed=0):
    """Return brightness, squared errors and counts of pixels, whose samples see ``value`` with a probability (H, W)."""
    random = np.random.default_rng(seed)
    seen = random.random((SAMPLES, *SIZE)) < probability
    samples = np.where(seen, value, background * (1 + 0.3 * random.normal(size=seen.shape)))
    own = samples.var(axis=0, ddof=1) / SAMPLES
    return samples.mean(axis=0).astype(np.float32), own.astype(np.float32), np.full(SIZE, SAMPLES, np.float32)


def glare_of(brightness, own, count):
    return find_glare(brightness, is_certain(brightness, own, count), float(np.quantile(brightness, 0.95)))


def lamp(height, width, coverage=1.0):
    probability = np.zeros(SIZE)
    probability[20 : 20 + height, 30 : 30 + width] = coverage
    return probability


@pytest.mark.parametrize("value", [1e2, 1e4, 1e6])
@pytest.mark.parametrize(("height", "width"), [(1, 1), (2, 2), (4, 4), (1, 25), (8, 8)])
def test_lamps_their_edges_and_what_is_beside_them(height, width, value):
    mask = glare_of(*drawn(lamp(height, width), value))
    expected = np.zeros(SIZE, bool)
    expected[18 : 22 + height, 28 : 32 + width] = True
    inner = np.zeros(SIZE, bool)
    inner[21 : 19 + height, 31 : 29 + width] = True  # of a larger lamp, which is not beside anything dark
    assert np.array_equal(mask, expected & ~inner)


def test_the_edge_of_a_lamp_that_few_samples_see_belongs_to_it():
    probability = lamp(3, 3)
    probability[19, 30:33] = 3 / SAMPLES
    brightness, own, count = drawn(probability, 1e4, seed=3)
    assert (brightness[19, 30:33] > 100).any()
    assert glare_of(brightness, own, count)[18, 30:33].all()


@pytest.mark.parametrize("probability", [1e-5, 1e-3])
def test_fireflies_are_no_glare(probability):
    """Of 4,800 squares hardly any has the five hits that make it certain."""
    assert glare_of(*drawn(np.full(SIZE, probability), 1e4)).mean() < 0.01


@pytest.mark.parametrize("background", [0.01, 1.0])
def test_noise_and_soft_light_are_no_glare(background):
    assert not glare_of(*drawn(np.zeros(SIZE), 0.0, background)).any()
    light = (1.0 + np.cos(np.arange(SIZE[1]) / 8.0) * 0.9) * np.ones(SIZE)
    assert not find_glare(light.astype(np.float32), np.ones(SIZE, bool), 1.0).any()


def test_a_disc_before_black_is_no_glare():
    """Nothing in it is far brighter than the picture as a whole, however dark the background is."""
    row, column = np.indices(SIZE)
    disc = np.where((row - 30) ** 2 + (column - 40) ** 2 < 400, 0.5, 1e-6).astype(np.float32)
    mask = find_glare(disc, np.ones(SIZE, bool), 0.5)
    assert not mask[disc > 0.1].any()


def test_few_samples_are_not_certain():
    brightness = np.ones(SIZE, np.float32)
    assert not is_certain(brightness, 0 * brightness, 3 * brightness).any()
    assert is_certain(brightness, 0 * brightness, 4 * brightness).all()
