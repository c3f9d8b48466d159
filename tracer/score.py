"""Error of an image against a reference: pure functions of two arrays (H, W, 3), linear unless said otherwise."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.objective import EPSILON

Floats = NDArray[np.float64]
LUMINANCE = np.array([0.212671, 0.715160, 0.072169])
"""Weights of linear sRGB in luminance, those of ``mi.luminance``."""


SSIM_WINDOW = 7
"""Pixels a side of scikit-image's default window."""


def luminance(image: ArrayLike) -> Floats:
    """Return the luminance (H, W) of a linear image (H, W, 3) or (H, W, 1)."""
    image = np.asarray(image, np.float64)
    return image @ LUMINANCE if image.shape[-1] == 3 else image[..., 0]


def mse(image: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean squared error over pixels and channels."""
    image, reference = same_shape(image, reference)
    return float(np.mean((image - reference) ** 2))


def relative_mse(image: ArrayLike, reference: ArrayLike, epsilon: float = EPSILON) -> float:
    """Return the mean of the squared error over the reference's squared luminance plus ``epsilon``."""
    image, reference = same_shape(image, reference)
    scale = luminance(reference) ** 2 + epsilon
    return float(np.mean((image - reference) ** 2 / scale[..., None]))


def psnr(image: ArrayLike, reference: ArrayLike) -> float:
    """Return the peak signal-to-noise ratio in dB of both images encoded as sRGB and clipped to [0, 1] (range 1)."""
    image, reference = same_shape(image, reference)
    error = mse(encode_srgb(image), encode_srgb(reference))
    return float("inf") if error == 0 else float(-10.0 * np.log10(error))


def ssim(image: ArrayLike, reference: ArrayLike) -> float:
    """Return scikit-image's structural similarity of both images encoded as sRGB and clipped to [0, 1] (range 1)."""
    from skimage.metrics import structural_similarity

    image, reference = same_shape(image, reference)
    if min(image.shape[:2]) < SSIM_WINDOW:
        raise ValueError(f"SSIM needs images of at least {SSIM_WINDOW} x {SSIM_WINDOW} pixels")
    return float(structural_similarity(encode_srgb(image), encode_srgb(reference), data_range=1.0, channel_axis=-1))


def encode_srgb(linear: ArrayLike) -> Floats:
    """Return linear values clipped to [0, 1] and encoded with the sRGB curve (IEC 61966-2-1)."""
    linear = np.clip(np.asarray(linear, np.float64), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


def same_shape(image: ArrayLike, reference: ArrayLike) -> tuple[Floats, Floats]:
    """Return both as float64. Raises ValueError if their shapes differ."""
    image, reference = np.asarray(image, np.float64), np.asarray(reference, np.float64)
    if image.shape != reference.shape:
        raise ValueError(f"image of shape {image.shape} and reference of shape {reference.shape} differ in size")
    return image, reference
