"""Pictures as text in a page: as half floats, so that a reader can choose the exposure, and as whole numbers."""

from __future__ import annotations

import base64
import zlib

import numpy as np
from numpy.typing import ArrayLike, NDArray

LARGEST = 65504.0
"""Largest number that a half float can hold."""


def encode_picture(image: ArrayLike) -> str:
    """Return linear values (H, W, 3) as text: channel by channel, as half floats, encoded by ``encode_words``."""
    values = np.clip(np.nan_to_num(np.asarray(image, np.float32)), -LARGEST, LARGEST).astype(np.float16)
    return encode_words(np.moveaxis(values, -1, 0).view(np.uint16))


def encode_counts(counts: ArrayLike) -> str:
    """Return samples per pixel (H, W), at most 65535, as text."""
    return encode_words(np.minimum(np.asarray(counts), 65535).astype(np.uint16)[None])


def encode_words(words: NDArray[np.uint16]) -> str:
    """Return 16-bit words (N, H, W) as text: differences along rows, low bytes before high ones, deflate, base64."""
    differences = np.diff(words, axis=-1, prepend=np.uint16(0))
    planes = np.stack([differences & 0xFF, differences >> 8]).astype(np.uint8)
    return base64.b64encode(zlib.compress(planes.tobytes(), 6)).decode("ascii")


def reduce(values: NDArray, factor: int) -> NDArray:
    """Return ``values`` (H, W, ...) averaged over ``factor`` x ``factor`` pixels; a rest at the edges is cut."""
    factor = min(factor, *values.shape[:2])
    if factor == 1:
        return values
    height, width = (size // factor for size in values.shape[:2])
    cut = np.asarray(values[: height * factor, : width * factor], np.float64)
    return cut.reshape(height, factor, width, factor, *values.shape[2:]).mean(axis=(1, 3))
