"""Error of an image against a reference: pure functions of two pictures, linear unless said otherwise.

A picture is an array (H, W, 3), of any numeric dtype. A grey picture, (H, W) or (H, W, 1), counts as three equal
channels. Every error raises ScoreError for two pictures of different sizes, if only one of them is grey, and for pixels
that are not finite.

Example:

>>> import numpy as np
>>> from tracer.image.metrics import bias, mse, relative_mse
>>> reference = np.full((8, 8, 3), 0.5)
>>> image = reference + 0.1
>>> round(mse(image, reference), 4), round(bias(image, reference), 4)
(0.01, 0.2)
>>> round(relative_mse(image, reference), 4)  # 0.01 / (0.5^2 + 0.01)
0.0385
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tracer.core.arrays import Floats
from tracer.errors import ScoreError
from tracer.image.colour import encode_srgb, luminance
from tracer.image.objective import EPSILON

SSIM_WINDOW = 7
"""Side in pixels of scikit-image's default window for structural similarity; a picture must be at least as large."""
DARK, MOST_STOPS = 2e-7, 24.0
"""DARK: a reference whose luminance is below this everywhere counts as black: HDR-FLIP finds no exposure for it, and
ends the process. MOST_STOPS: the exposure in stops that such a reference gets, the largest that HDR-FLIP chooses."""
TRIMMED = 0.001
"""Share of the pixels that the trimmed mean leaves out: those with the largest errors."""


@dataclass(frozen=True)
class Scores:
    """All errors of one picture against its reference."""

    mse: float
    """Mean squared error over pixels and channels."""
    relative_mse: float
    """Mean of the squared error over the squared luminance of the reference."""
    relative_mse_trimmed: float
    """The relative error without the pixels that err most, see ``TRIMMED``."""
    psnr: float
    """Peak signal-to-noise ratio in dB of both pictures as a screen shows them."""
    ssim: float
    """Structural similarity of both pictures as a screen shows them; 1 for equal pictures."""
    flip: float
    """Mean HDR-FLIP (Andersson et al. 2021); the reference alone chooses the exposures."""
    bias: float
    """Mean signed error of the luminance over the mean luminance of the reference."""


def all_scores(image: ArrayLike, reference: ArrayLike) -> Scores:
    """Return every error of ``image``, both (H, W, 3) or grey, in linear sRGB, at least 7 pixels a side.

    Raises ScoreError for pictures that cannot be compared.

    Example::

        import tracer
        from tracer.image.metrics import all_scores

        image = tracer.render("scene.xml", spp=16).rgb
        reference = tracer.render("scene.xml", spp=256, seed=1).rgb
        print(all_scores(image, reference).relative_mse)
    """
    image, reference = comparable(image, reference, least_side=SSIM_WINDOW)
    return Scores(
        mse(image, reference),
        relative_mse(image, reference),
        relative_mse_trimmed(image, reference),
        psnr(image, reference),
        ssim(image, reference),
        flip(image, reference),
        bias(image, reference),
    )


def mse(image: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean squared error over pixels and channels, in the squared unit of the pictures, radiance."""
    image, reference = comparable(image, reference)
    return float(np.mean((image - reference) ** 2))


def relative_mse(image: ArrayLike, reference: ArrayLike, epsilon: float = EPSILON) -> float:
    """Return the mean of the squared error over the reference's squared luminance plus ``epsilon``; it has no unit."""
    image, reference = comparable(image, reference)
    return float(np.mean((image - reference) ** 2 / relative_scale(reference, epsilon)[..., None]))


def relative_scale(reference: ArrayLike, epsilon: float = EPSILON) -> Floats:
    """Return what a squared error is divided by, (H, W): the squared luminance plus ``epsilon``."""
    return luminance(reference) ** 2 + epsilon


def relative_mse_trimmed(image: ArrayLike, reference: ArrayLike, share: float = TRIMMED) -> float:
    """Return ``relative_mse`` without the ``share`` of the pixels (at least one) that err most, such as fireflies."""
    image, reference = comparable(image, reference)
    errors = ((image - reference) ** 2).mean(axis=-1) / relative_scale(reference)
    count = errors.size - max(1, round(share * errors.size))
    return float(np.partition(errors.ravel(), count - 1)[:count].mean()) if count > 0 else float(errors.mean())


def bias(image: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean signed error of the luminance over the reference's mean luminance; 0 for a black reference.

    0.02 is 2 % too bright.
    """
    image, reference = comparable(image, reference)
    mean = float(luminance(reference).mean())
    return float(luminance(image - reference).mean()) / mean if mean else 0.0


def flip(image: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean HDR-FLIP error, 0 to 1, at the authors' 67 pixels per degree and exposures from the reference."""
    import flip_evaluator

    image, reference = comparable(image, reference)
    positive = [np.maximum(values, 0.0).astype(np.float32) for values in (reference, image)]
    is_dark = luminance(positive[0]).max() < DARK
    exposures = {"startExposure": MOST_STOPS, "stopExposure": MOST_STOPS} if is_dark else {}
    return float(flip_evaluator.evaluate(*positive, "HDR", applyMagma=False, parameters=exposures)[1])


def psnr(image: ArrayLike, reference: ArrayLike) -> float:
    """Return the peak signal-to-noise ratio in dB of both images encoded as sRGB and clipped to [0, 1] (range 1).

    It is infinite for equal pictures.
    """
    image, reference = comparable(image, reference)
    error = mse(encode_srgb(image), encode_srgb(reference))
    return float("inf") if error == 0 else float(-10.0 * np.log10(error))


def ssim(image: ArrayLike, reference: ArrayLike) -> float:
    """Return scikit-image's structural similarity of both images encoded as sRGB and clipped to [0, 1] (range 1).

    It is at most 1, which equal pictures have. Pictures must have at least 7 pixels a side.
    """
    from skimage.metrics import structural_similarity

    image, reference = comparable(image, reference, least_side=SSIM_WINDOW)
    return float(structural_similarity(encode_srgb(image), encode_srgb(reference), data_range=1.0, channel_axis=-1))


def comparable(
    image: ArrayLike,
    reference: ArrayLike,
    names: tuple[str, str] = ("the image", "the reference"),
    least_side: int = 1,
) -> tuple[Floats, Floats]:
    """Return two pictures as (H, W, 3) float64, a grey picture as three equal channels.

    ``names``: what a message calls them. ``least_side``: least width and height in pixels. Raises ScoreError for what
    is no picture, for pixels that are not finite as float32, for two different sizes, and if only one picture is grey.
    """
    pictures = [picture(values, name) for values, name in zip((image, reference), names, strict=True)]
    sizes = [f"{values.shape[1]} x {values.shape[0]}" for values in pictures]
    if sizes[0] != sizes[1]:
        raise ScoreError(
            sentence(f"{names[0]} is {sizes[0]} pixels and {names[1]} is {sizes[1]}; render both at one size.")
        )
    channels = [values.shape[2] for values in pictures]
    if channels[0] != channels[1]:
        grey, colour = names if channels[0] == 1 else names[::-1]
        raise ScoreError(sentence(f"{grey} is grey and {colour} is in colour; render both alike."))
    if min(pictures[0].shape[:2]) < least_side:
        raise ScoreError(
            sentence(
                f"{names[0]} is {sizes[0]} pixels, and structural similarity needs at least {least_side} a side; "
                "render both larger."
            )
        )
    first, second = (np.broadcast_to(values, (*values.shape[:2], 3)) for values in pictures)
    return first, second


def picture(values: ArrayLike, name: str) -> Floats:
    """Return a picture as float64, (H, W, 3) or (H, W, 1). Raises ScoreError; ``name``: how its message calls it."""
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise ScoreError(sentence(f"{name} is no array of numbers; give one of shape (H, W, 3).")) from None
    array = array[..., None] if array.ndim == 2 else array
    if array.ndim != 3 or array.shape[2] not in (1, 3):
        raise ScoreError(
            sentence(f"{name} has the shape {np.shape(values)}; give (H, W, 3), or (H, W) or (H, W, 1) if it is grey.")
        )
    if array.size == 0:
        raise ScoreError(sentence(f"{name} has the shape {array.shape} and no pixel; render it anew."))
    require_finite(array, name)
    return array


def require_finite(values: ArrayLike, name: str) -> None:
    """Raise ScoreError if pixels (H, W, C) are not finite as float32; ``name``: what its message calls the picture."""
    bad_count = np.count_nonzero(~(np.abs(values) <= np.finfo(np.float32).max).all(axis=-1))
    if bad_count:
        pixels = f"1 pixel of {name} is" if bad_count == 1 else f"{bad_count} pixels of {name} are"
        raise ScoreError(f"{pixels} not finite, so it has no score; render it anew.")


def sentence(text: str) -> str:
    """Return ``text`` with its first letter a capital."""
    return text[:1].upper() + text[1:]
