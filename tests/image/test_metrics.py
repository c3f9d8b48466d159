"""Metrics against hand values and scikit-image."""

import numpy as np
import pytest
import skimage.metrics

from tracer.errors import ScoreError, TracerError
from tracer.image import colour, metrics

RNG = np.random.default_rng(3)
REFERENCE = RNG.uniform(0, 1, (16, 20, 3))
IMAGE = np.clip(REFERENCE + RNG.normal(0, 0.05, REFERENCE.shape), 0, 1)


def test_mse_and_psnr_are_those_of_scikit_image():
    assert metrics.mse(IMAGE, REFERENCE) == pytest.approx(skimage.metrics.mean_squared_error(REFERENCE, IMAGE))
    encoded = colour.encode_srgb(REFERENCE), colour.encode_srgb(IMAGE)
    assert metrics.psnr(IMAGE, REFERENCE) == pytest.approx(
        skimage.metrics.peak_signal_noise_ratio(*encoded, data_range=1)
    )


def test_relative_mse_by_hand():
    reference = np.full((2, 2, 3), 0.3)
    assert metrics.relative_mse(reference + 0.1, reference) == pytest.approx(0.01 / (0.09 + 0.01))


def test_identical_images():
    assert metrics.psnr(IMAGE, IMAGE) == np.inf
    assert metrics.ssim(IMAGE, IMAGE) == pytest.approx(1)
    assert metrics.relative_mse(IMAGE, IMAGE) == 0


NAMES = ("mse", "relative_mse", "relative_mse_trimmed", "bias", "flip", "psnr", "ssim", "all_scores")
METRICS = {name: getattr(metrics, name) for name in NAMES}


def spoilt(value, pixels=2):
    """Return the image with pixels that have a value in one channel."""
    image = IMAGE.copy()
    image[3, :pixels, 1] = value
    return image


@pytest.mark.parametrize("name", METRICS)
@pytest.mark.parametrize(
    ("image", "reference", "message"),
    [
        (spoilt(np.nan), REFERENCE, "^2 pixels of the image are not finite"),
        (spoilt(np.inf, 1), REFERENCE, "^1 pixel of the image is not finite"),
        (spoilt(-1e39), REFERENCE, "^2 pixels of the image are not finite"),
        (IMAGE, spoilt(np.nan, 20), "^20 pixels of the reference are not finite"),
        (IMAGE[..., [0, 1, 2, 0]], REFERENCE[..., [0, 1, 2, 0]], r"^The image has the shape \(16, 20, 4\); give \(H"),
        (IMAGE, REFERENCE[..., :2], r"^The reference has the shape \(16, 20, 2\)"),
        (IMAGE[None], REFERENCE, r"^The image has the shape \(1, 16, 20, 3\)"),
        (IMAGE[0, 0], REFERENCE, r"^The image has the shape \(3,\)"),
        (IMAGE[:0], REFERENCE[:0], r"^The image has the shape \(0, 20, 3\) and no pixel"),
        (IMAGE[..., :1], REFERENCE, "^The image is grey and the reference is in colour"),
        (IMAGE, REFERENCE[..., 0], "^The reference is grey and the image is in colour"),
        (IMAGE[1:], REFERENCE, "^The image is 20 x 15 pixels and the reference is 20 x 16; render both at one size"),
        (IMAGE.swapaxes(0, 1), REFERENCE, "^The image is 16 x 20 pixels and the reference is 20 x 16"),
        ([["a"]], REFERENCE, "^The image is no array of numbers"),
    ],
)
def test_pictures_that_cannot_be_compared_are_refused_by_every_error(name, image, reference, message):
    with pytest.raises(ScoreError, match=message) as caught:
        METRICS[name](image, reference)
    assert isinstance(caught.value, TracerError)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("name", METRICS)
@pytest.mark.parametrize("grey", [lambda image: image[..., 0], lambda image: image[..., :1]])
def test_a_grey_picture_counts_as_three_channels_that_are_alike(name, grey):
    three = [METRICS[name](*(image[..., :1].repeat(3, axis=-1) for image in (IMAGE, REFERENCE))) for _ in range(3)]
    assert [METRICS[name](grey(IMAGE), grey(REFERENCE)) for _ in range(3)] == three
    assert three[0] == three[2]


def test_order_of_the_memory_does_not_matter():
    for name, metric in METRICS.items():
        assert metric(np.asfortranarray(IMAGE), REFERENCE[::-1][::-1]) == metric(IMAGE, REFERENCE), name


def test_structural_similarity_needs_its_window():
    # 7: the side of the window of scikit-image
    assert metrics.ssim(IMAGE[:7, :7], REFERENCE[:7, :7]) < 1
    for metric in (metrics.ssim, metrics.all_scores):
        for small in (np.s_[:6], np.s_[:, :6]):
            with pytest.raises(ScoreError, match="needs at least 7 a side; render both larger"):
                metric(IMAGE[small], REFERENCE[small])
    assert 0 < metrics.flip(IMAGE[:1, :1], REFERENCE[:1, :1]) < 1


def test_trimmed_error_forgets_fireflies():
    reference = np.full((50, 40, 3), 0.5)
    image = reference + 0.01
    plain = metrics.relative_mse(image, reference)
    assert metrics.relative_mse_trimmed(image, reference) == pytest.approx(plain)
    image[3, 4] = 1e6
    image[9, 1] = 1e3
    assert metrics.relative_mse(image, reference) > 1e6 * plain
    assert metrics.relative_mse_trimmed(image, reference) == pytest.approx(plain)  # 2 of 2000 pixels are left out
    image[7, 7] = 1e3
    assert metrics.relative_mse_trimmed(image, reference) > 100 * plain


def test_bias_is_signed_and_relative():
    reference = np.random.default_rng(1).uniform(0.2, 2, (8, 8, 3))
    assert metrics.bias(1.03 * reference, reference) == pytest.approx(0.03)
    assert metrics.bias(0.9 * reference, reference) == pytest.approx(-0.1)


def test_flip_is_the_authors():
    import flip_evaluator

    positive = [np.maximum(values, 0).astype(np.float32) for values in (REFERENCE, IMAGE)]
    _, expected, parameters = flip_evaluator.evaluate(*positive, "HDR", applyMagma=False)
    assert metrics.flip(IMAGE, REFERENCE) == pytest.approx(expected)
    assert metrics.flip(REFERENCE, REFERENCE) == 0
    # the exposures come from the reference: the same for every picture that is compared with it
    other = flip_evaluator.evaluate(positive[0], 3 * positive[1], "HDR", applyMagma=False)[2]
    assert other == parameters


def test_all_scores():
    found = metrics.all_scores(IMAGE, REFERENCE)
    assert found.mse == metrics.mse(IMAGE, REFERENCE)
    assert found.ssim == metrics.ssim(IMAGE, REFERENCE)


@pytest.mark.parametrize("scale", [0.0, 1e-30, 1e-8, 1e-7, 3e-7])
def test_flip_of_a_black_reference(scale):
    """The authors' library finds no exposure for it, and ends the process."""
    assert metrics.flip(REFERENCE * scale, REFERENCE * scale) == 0
    assert 0.5 < metrics.flip(IMAGE, REFERENCE * scale) <= 1


def test_flip_of_a_dark_reference_is_seen_24_stops_brighter():
    import flip_evaluator

    image, reference = 1e-8 * IMAGE, 1e-8 * REFERENCE
    brighter = [(2.0**24 * values).astype(np.float32) for values in (reference, image)]
    exposures = {"startExposure": 0.0, "stopExposure": 0.0}
    expected = flip_evaluator.evaluate(*brighter, "HDR", applyMagma=False, parameters=exposures)[1]
    assert metrics.flip(image, reference) == pytest.approx(expected, rel=1e-5)
    assert expected > 0.005


def test_trimmed_error_forgets_one_pixel_of_a_small_picture():
    reference = np.full((5, 5, 3), 0.5)
    image = reference + 0.01
    image[2, 3] = 1e6
    assert metrics.relative_mse_trimmed(image, reference) == pytest.approx(
        metrics.relative_mse(reference + 0.01, reference)
    )


def test_flip_takes_negative_values_as_none():
    image = IMAGE - 0.5
    assert image.min() < -0.3
    assert metrics.flip(image, REFERENCE) == metrics.flip(np.maximum(image, 0), REFERENCE)


def test_bias_without_any_light_is_none():
    assert metrics.bias(IMAGE, np.zeros_like(IMAGE)) == 0
