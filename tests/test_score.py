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


def test_trimmed_error_forgets_fireflies():
    reference = np.full((50, 40, 3), 0.5)
    image = reference + 0.01
    plain = score.relative_mse(image, reference)
    assert score.relative_mse_trimmed(image, reference) == pytest.approx(plain)
    image[3, 4] = 1e6
    image[9, 1] = 1e3
    assert score.relative_mse(image, reference) > 1e6 * plain
    assert score.relative_mse_trimmed(image, reference) == pytest.approx(plain)  # 2 of 2000 pixels are left out
    image[7, 7] = 1e3
    assert score.relative_mse_trimmed(image, reference) > 100 * plain


def test_bias_is_signed_and_relative():
    reference = np.random.default_rng(1).uniform(0.2, 2, (8, 8, 3))
    assert score.bias(1.03 * reference, reference) == pytest.approx(0.03)
    assert score.bias(0.9 * reference, reference) == pytest.approx(-0.1)


def test_flip_is_the_authors():
    import flip_evaluator

    positive = [np.maximum(values, 0).astype(np.float32) for values in (REFERENCE, IMAGE)]
    _, expected, parameters = flip_evaluator.evaluate(*positive, "HDR", applyMagma=False)
    assert score.flip(IMAGE, REFERENCE) == pytest.approx(expected)
    assert score.flip(REFERENCE, REFERENCE) == 0
    # the exposures come from the reference: the same for every picture that is compared with it
    other = flip_evaluator.evaluate(positive[0], 3 * positive[1], "HDR", applyMagma=False)[2]
    assert other == parameters


def test_all_scores():
    found = score.all_scores(IMAGE, REFERENCE)
    assert found.mse == score.mse(IMAGE, REFERENCE)
    assert found.ssim == score.ssim(IMAGE, REFERENCE)
    with pytest.raises(ValueError, match="differ in size"):
        score.all_scores(IMAGE[1:], REFERENCE)


@pytest.mark.parametrize("scale", [0.0, 1e-30, 1e-8, 1e-7, 3e-7])
def test_flip_of_a_black_reference(scale):
    """The authors' library finds no exposure for it, and ends the process."""
    assert score.flip(REFERENCE * scale, REFERENCE * scale) == 0
    assert 0.5 < score.flip(IMAGE, REFERENCE * scale) <= 1
