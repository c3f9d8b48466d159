"""Pictures as text."""

import base64
import zlib

import numpy as np
import pytest

from tracer.study.page.encode import LARGEST, encode_counts, encode_picture, reduce


def decode(text, channels, height, width):
    """What pixels.js does, in the plainest way."""
    planes = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8).reshape(2, channels, height, width)
    return np.cumsum(planes[0] + 256 * planes[1].astype(np.int64), axis=-1).astype(np.uint16)


def test_a_picture_survives():
    image = np.random.default_rng(0).normal(1, 2, (7, 9, 3)).astype(np.float32)
    image[0, 0] = [1e9, np.nan, -1e9]
    found = np.moveaxis(decode(encode_picture(image), 3, 7, 9).view(np.float16), 0, -1)
    np.testing.assert_array_equal(found[0, 0], [LARGEST, 0, -LARGEST])
    np.testing.assert_array_equal(found[1:], image[1:].astype(np.float16))


def test_counts_survive():
    counts = np.array([[0, 1, 70000], [65535, 3, 2]])
    np.testing.assert_array_equal(decode(encode_counts(counts), 1, 2, 3)[0], np.minimum(counts, 65535))


def test_smaller_pictures_are_means():
    values = np.arange(5 * 6.0).reshape(5, 6)
    np.testing.assert_allclose(reduce(values, 2), [[3.5, 5.5, 7.5], [15.5, 17.5, 19.5]])
    assert reduce(np.ones((5, 6, 3)), 2).shape == (2, 3, 3)
    assert reduce(values, 1) is values


def test_smooth_pictures_take_little_room():
    ramp = np.broadcast_to(np.linspace(0, 1, 256)[None, :, None], (192, 256, 3))
    assert len(encode_picture(ramp)) < 20_000
    assert len(encode_picture(np.random.default_rng(0).random((192, 256, 3)))) == pytest.approx(350_000, rel=0.2)
