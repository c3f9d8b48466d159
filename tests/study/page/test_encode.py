"""Pictures and maps as codes, and as images within a page."""

import base64
import io

import numpy as np
import pytest
from PIL import Image

from tracer.study.page.encode import (
    BRIGHTEST,
    HEADROOM,
    count_codes,
    error_codes,
    image_url,
    picture_codes,
    picture_values,
    reduce,
)


def decode(url):
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(url.partition(",")[2]))))


def test_values_of_pictures_survive_within_a_few_percent_beyond_white():
    values = np.geomspace(0.01, 16, 1000)
    off = np.abs(picture_values(picture_codes(values)) / values - 1)
    assert off[values < 4].max() < 0.04
    assert off.max() < 0.08  # 16 is four stops above white
    np.testing.assert_array_equal(picture_codes([-1.0, np.nan, 0.0, BRIGHTEST, 1e9, np.inf]), [0, 0, 0, 255, 255, 255])
    assert picture_values([0, 255]) == pytest.approx([0, BRIGHTEST])
    # Reinhard's x / (1 + x) brings white to one half, which the curve of sRGB shows as 188.
    assert picture_codes(1.0) == pytest.approx(188, abs=1)


def test_errors_and_counts_survive():
    errors = np.linspace(0, 2.0, 500)
    restored = HEADROOM * 0.5 * (error_codes(errors, 0.5) / 255.0) ** 2
    np.testing.assert_allclose(restored, errors, atol=0.008)
    counts = np.array([8, 16, 64, 512])
    restored = 8 * (512 / 8) ** (count_codes(counts, 8, 512) / 255.0)
    np.testing.assert_allclose(restored, counts, rtol=0.01)
    assert not count_codes(np.full((2, 2), 7), 7, 7).any()


def test_exact_images_keep_every_code_and_others_nearly():
    generator = np.random.default_rng(0)
    codes = np.clip(generator.normal(120, 30, (64, 80, 3)), 0, 255).astype(np.uint8)
    np.testing.assert_array_equal(decode(image_url(codes, exact=True)), codes)
    grey = codes[..., 0]
    lossy = decode(image_url(grey))
    difference = (lossy[..., 0] if lossy.ndim == 3 else lossy) - grey.astype(float)
    assert 0 < np.sqrt(np.mean(difference**2)) < 4
    assert len(image_url(grey)) < 0.8 * len(image_url(grey, exact=True))


def test_an_image_without_content_is_png():
    assert image_url(np.zeros((64, 64), np.uint8)).startswith(("data:image/png", "data:image/webp"))
    assert len(image_url(np.zeros((64, 64), np.uint8))) < 200


def test_smaller_pictures_are_means():
    values = np.arange(5 * 6.0).reshape(5, 6)
    np.testing.assert_allclose(reduce(values, 2), [[3.5, 5.5, 7.5], [15.5, 17.5, 19.5]])
    assert reduce(np.ones((5, 6, 3)), 2).shape == (2, 3, 3)
    assert reduce(values, 1) is values
