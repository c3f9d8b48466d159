"""Metrics against hand values and scikit-image."""

import numpy as np
import pytest
from skimage import metrics

from tracer import score

RNG = np.random.default_rng(3)
REFERENCE = RNG.uniform(0, 1, (16, 20, 3))
IMAGE = np.clip(REFERENCE + RNG.normal(0, 0.05, REFERENCE.shape), 0, 1)


def test_mse_and_psnr_are_those_of_scikit_image():
    assert score.mse(IMAGE, REFERENCE) == pytest.approx(metrics.mean_squared_error(REFERENCE, IMAGE))
    encoded = score.encode_srgb(REFERENCE), score.encode_srgb(IMAGE)
    assert score.psnr(IMAGE, REFERENCE) == pytest.approx(metrics.peak_signal_noise_ratio(*encoded, data_range=1))


def test_relative_mse_by_hand():
    reference = np.full((2, 2, 3), 0.3)
    assert score.relative_mse(reference + 0.1, reference) == pytest.approx(0.01 / (0.09 + 0.01))


def test_srgb_of_known_values():
    # IEC 61966-2-1: linear 0.214041 is half of the encoded range
    assert score.encode_srgb([0.0, 0.21404114, 1.0, 7.0, -1.0]) == pytest.approx([0, 0.5, 1, 1, 0], abs=1e-6)


def test_luminance_is_mitsubas():
    import mitsuba as mi

    colour = [0.2, 0.7, 0.4]
    expected = mi.luminance(mi.Color3f(colour))[0]
    assert score.luminance(np.array(colour)[None, None])[0, 0] == pytest.approx(expected, abs=1e-6)


def test_identical_images():
    assert score.psnr(IMAGE, IMAGE) == np.inf
    assert score.ssim(IMAGE, IMAGE) == pytest.approx(1)
    assert score.relative_mse(IMAGE, IMAGE) == 0


def test_different_sizes_are_named():
    with pytest.raises(ValueError, match=r"\(2, 3, 3\).*\(3, 2, 3\)"):
        score.mse(np.zeros((2, 3, 3)), np.zeros((3, 2, 3)))
