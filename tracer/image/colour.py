"""Colour: luminance, the sRGB curve, and how a picture or a map is shown.

Example:

>>> import numpy as np
>>> from tracer.image.colour import display, luminance
>>> grey = np.full((2, 3, 3), 0.5)
>>> float(luminance(grey)[0, 0].round(3))
0.5
>>> float(display(grey)[0, 0, 0].round(3))  # encoded as sRGB
0.735
"""

from __future__ import annotations

import base64
import io

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.core.arrays import Floats
from tracer.errors import ScoreError

LUMINANCE = np.array([0.212671, 0.715160, 0.072169])
"""Weights of red, green and blue (linear sRGB) in luminance, the same as in ``mi.luminance``."""


def luminance(image: ArrayLike) -> Floats:
    """Return the luminance (H, W) of a linear image (H, W, 3) or (H, W, 1). Raises ScoreError for other channels."""
    image = np.asarray(image, np.float64)
    if image.ndim == 0 or image.shape[-1] not in (1, 3):
        raise ScoreError(f"An image of shape {image.shape} has no luminance; give 3 channels, or 1 of a grey image.")
    return image @ LUMINANCE if image.shape[-1] == 3 else image[..., 0]


def encode_srgb(linear: ArrayLike) -> Floats:
    """Return linear values clipped to [0, 1] and encoded with the sRGB curve (IEC 61966-2-1)."""
    linear = np.clip(np.asarray(linear, np.float64), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


def decode_srgb(encoded: ArrayLike) -> Floats:
    """Return the linear values of ``encoded`` values in [0, 1], which the sRGB curve encoded (IEC 61966-2-1)."""
    encoded = np.asarray(encoded, np.float64)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def display(image: NDArray) -> NDArray[np.float64]:
    """Return an image (H, W, C) as a screen shows it: RGB in [0, 1], encoded as sRGB. Alpha and AOVs are left out."""
    colour = image[..., :3] if image.shape[-1] >= 3 else image[..., :1].repeat(3, axis=-1)
    return encode_srgb(colour)


def heat(values: NDArray) -> NDArray[np.float64]:
    """Return counts (H, W) as colours (H, W, 3) in [0, 1], on a logarithmic scale, dark for low counts."""
    import matplotlib

    logarithm = np.log2(np.maximum(values.astype(np.float64), 1e-6))
    span = max(float(np.ptp(logarithm)), 1e-6)
    return matplotlib.colormaps["magma"]((logarithm - logarithm.min()) / span)[..., :3]


def as_png(picture: NDArray[np.float64]) -> str:
    """Return a picture (H, W, 3) in [0, 1] as a PNG encoded in base64."""
    from matplotlib.image import imsave

    stream = io.BytesIO()
    imsave(stream, np.clip(picture, 0, 1), format="png")
    return base64.b64encode(stream.getvalue()).decode()
