"""Pictures and maps as codes of eight bits, and these as the URLs of small images within the page.

A picture keeps what is brighter than a screen shows: before the sRGB curve its values x are bent by
x (1 + 1/BRIGHTEST) / (1 + x) (Reinhard et al. 2002, equation 4, in another form), so the page can change the exposure.
"""

from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.core.arrays import Floats
from tracer.core.extras import require_package

BRIGHTEST = 128.0
"""Largest linear value that a code stands for; 1 is white on a screen at exposure 0."""
HEADROOM = 4.0
"""Largest error that a code stands for, in units of the error at the top of the scale of colours."""
QUALITY = 90
"""Quality of WebP images that are not exact. Grain stays: codes of noisy renderings were off by 2.9 (RMS) at 0.26 bytes
per pixel, where JPEG without chroma subsampling was off by 3.9 in as many bytes, and exact codes took 4.5 times
that (48 pictures of three scenes, 256 x 192, WebP's method 6)."""
Codes = NDArray[np.uint8]


def require_image_writer() -> Any:
    """Return the module ``PIL.Image``, which writes WebP. Raises MissingPackageError if it is not installed."""
    return require_package("PIL.Image", "Pillow", "The page of a study", "study")


def picture_codes(image: ArrayLike) -> Codes:
    """Return codes of linear values of any shape; below 0 and NaN count as 0, above BRIGHTEST as BRIGHTEST."""
    values = np.clip(np.nan_to_num(np.asarray(image, np.float64), posinf=BRIGHTEST), 0, BRIGHTEST)
    bent = values * (1 + 1 / BRIGHTEST) / (1 + values)
    return to_bytes(srgb_curve(bent))


def picture_values(codes: ArrayLike) -> Floats:
    """Return the linear values of codes, the inverse of ``picture_codes``."""
    shown = np.asarray(codes, np.float64) / 255
    bent = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    return bent / (1 + 1 / BRIGHTEST - bent)


def error_codes(errors: ArrayLike, top: float) -> Codes:
    """Return codes of errors, which are as the square root of errors from 0 to HEADROOM times ``top``."""
    return to_bytes(np.sqrt(np.clip(np.nan_to_num(np.asarray(errors, np.float64)) / (HEADROOM * top), 0, 1)))


def count_codes(counts: ArrayLike, least: float, most: float) -> Codes:
    """Return codes of samples per pixel, which are as their logarithm from ``least`` (at least 1) to ``most``."""
    least, most = max(least, 1.0), max(most, 1.0)
    if most <= least:
        return np.zeros(np.shape(counts), np.uint8)
    return to_bytes(np.log(np.clip(np.asarray(counts, np.float64), least, most) / least) / np.log(most / least))


def srgb_curve(values: ArrayLike) -> Floats:
    """Return linear values from 0 to 1 with the curve of sRGB (IEC 61966-2-1)."""
    linear = np.asarray(values, np.float64)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def to_bytes(values: ArrayLike) -> Codes:
    """Return values from 0 to 1 as whole numbers from 0 to 255."""
    return np.rint(255 * np.asarray(values)).astype(np.uint8)


def image_url(codes: Codes, exact: bool = False) -> str:
    """Return codes (H, W) or (H, W, 3) as the URL of an image: WebP, or PNG where that is smaller.

    ``exact``: whether every code is kept as it is; else WebP is lossy, of QUALITY.
    """
    image = require_image_writer().fromarray(codes)
    lossy = {"quality": QUALITY, "method": 4}
    ways: dict[str, dict[str, Any]] = {
        "webp": {"lossless": True, "quality": 40, "method": 2} if exact else lossy,
        "png": {},
    }
    contents = {}
    for name, options in ways.items():
        file = io.BytesIO()
        image.save(file, name, **options)
        contents[name] = file.getvalue()
    name, content = min(contents.items(), key=lambda entry: len(entry[1]))
    return f"data:image/{name};base64,{base64.b64encode(content).decode('ascii')}"


def reduce(values: NDArray, factor: int) -> NDArray:
    """Return ``values`` (H, W, ...) averaged over ``factor`` x ``factor`` pixels; a rest at the edges is cut."""
    factor = min(factor, *values.shape[:2])
    if factor == 1:
        return values
    height, width = (size // factor for size in values.shape[:2])
    cut = np.asarray(values[: height * factor, : width * factor], np.float64)
    return cut.reshape(height, factor, width, factor, *values.shape[2:]).mean(axis=(1, 3))
