"""How noisy a picture still is: the error that a stated share of its pixels keeps within.

The error of a pixel is that of the picture as ``exposure`` shows it. For ``relative`` it is the part of the pixel's
brightness by which it is off (of 0.1 where it is darker), for ``display`` a difference on an sRGB screen from 0 to 1,
for ``absolute`` radiance times 2^exposure; ``denoised`` is judged as ``relative``, before anything is denoised. Over
colour channels it is the root of the mean square. Where the picture has alpha, that is judged as well, as the part of
full cover by which it is off, whatever the exposure: a pixel is off by the larger of both. AOVs are not judged.

Two sources. The standard errors say how errors are distributed over the picture, but a stratified sequence errs less
than they say, and rare light errs by more. How far the picture moved in a round is a measurement: while counts
double, the mean moves by as much, in standard deviation, as it is still off. So the quantile that standard errors
predict for the move is compared with that of the move itself, and the ratio carried over to what is left. A ratio that
rises from round to round, as when rare light is being discovered, is taken to go on rising.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter
from scipy.special import erf

from tracer.core.arrays import Floats, spread_out
from tracer.image import objective
from tracer.image.colour import encode_srgb
from tracer.scene.frame import Frame
from tracer.settings import Settings

LOOKED_AT = 1 << 16
"""About so many pixels are looked at, evenly spread."""
STEPS = 60
"""Of the bisection of a logarithm."""
LEAST_GROWTH = 1.5
"""Of all samples, before the move of the picture is measured again: where few pixels get samples, hardly any moves.
After 26 and then 32 samples per pixel what was said was a quarter of the true error."""
TREND_POWER, MOST_TREND = 1.5, 2.0
"""A rise from round to round is taken to go on a bit faster, but not to more than twice as much: on the bundled scenes
that leaves few predictions too low, as those at which a render stops tend to be."""


@dataclass(frozen=True)
class Noise:
    """What is known of the error after a round."""

    error: float
    """``share`` of the pixels are estimated to be off by no more."""
    converged: float | None
    """Share of the pixels within the target; None without one."""
    needed: float
    """Times as many samples meet the target, if the squared error falls as one over their number; 1 if it is met."""
    measured: bool
    """Whether the picture was seen to move; if not, standard errors alone say so."""


@dataclass
class NoiseMeter:
    """Follows a picture from round to round."""

    image: NDArray[np.float32] | None = None
    """(H, W, C): as it was when its move was last measured."""
    count: NDArray[np.uint32] | None = None
    """(H, W): samples of each pixel then."""
    factor: float | None = None
    """Measured over predicted move, the last time."""
    scale: float | None = None
    """By which standard errors are multiplied."""
    counted: NDArray[np.bool_] | None = None
    """(H, W): pixels that matter; None: all of them."""

    def follow(
        self,
        frame: Frame,
        settings: Settings,
        image: NDArray[np.float32],
        stderr: NDArray[np.float32],
        count: NDArray[np.uint32],
    ) -> None:
        """Take in the picture (H, W, C) after a round, with its standard errors and counts (H, W).

        After a short round there is nothing to learn: the picture is then measured from where it was before that one.
        """
        if self.count is not None and count.sum(dtype=np.float64) < LEAST_GROWTH * self.count.sum(dtype=np.float64):
            return
        if self.image is not None and self.count is not None:
            moved = self.some(errors(frame, settings, image, image - self.image))
            now, before = (uniform_filter(each.astype(np.float64), 3, mode="nearest") for each in (count, self.count))
            growth = np.maximum(now / np.maximum(before, 1e-9) - 1.0, 0.0)
            expected = self.some(errors(frame, settings, image, stderr * np.sqrt(growth)[..., None]))
            most = bound(expected, settings.noise_share)
            factor = float(np.quantile(moved, settings.noise_share)) / most if most > 0 else 1.0
            trend = factor / self.factor if self.factor else 1.0
            self.factor, self.scale = factor, factor * min(max(trend, 1.0) ** TREND_POWER, MOST_TREND)
        self.image, self.count = image, count

    def look(self, frame: Frame, settings: Settings, image: NDArray[np.float32], stderr: NDArray[np.float32]) -> Noise:
        """Return the noise of a picture (H, W, C) with its standard errors."""
        scale = 1.0 if self.scale is None else self.scale
        deviation = scale * self.some(errors(frame, settings, image, stderr))
        error, target = bound(deviation, settings.noise_share), settings.noise
        converged, needed = (None, 1.0) if target is None else (within(deviation, target), (error / target) ** 2)
        return Noise(error, converged, max(needed, 1.0), self.scale is not None)

    def some(self, values: Floats) -> Floats:
        """Return the values (H, W) of LOOKED_AT pixels that count, or a few more, (P,)."""
        those = values.ravel() if self.counted is None else values[self.counted]
        return those[spread_out(those.size, LOOKED_AT)]


def errors(frame: Frame, settings: Settings, image: NDArray, deviation: NDArray) -> Floats:
    """Return by how much each pixel (H, W) of a picture is off if its channels are by ``deviation``, both (H, W, C).

    Alpha is left out where there is no noise target, as then the error is asked for to denoise colours.
    """
    luminance, colour = frame.luminance(image), root_mean_square(deviation, frame)
    off = seen(settings.objective, settings.exposure, luminance, colour)
    if settings.noise is None or not frame.has_alpha:
        return off
    return np.maximum(off, np.abs(deviation[..., frame.colour_channels]))


def seen(name: str, exposure: float, luminance: NDArray, deviation: NDArray) -> Floats:
    """Return the error of an objective at an exposure of pixels of mean luminance L that are off by s, (H, W) both."""
    if name == "display":
        return on_screen(luminance * 2.0**exposure, deviation * 2.0**exposure)
    return np.sqrt(objective.weights(name, luminance, exposure)) * deviation


def on_screen(luminance: NDArray, deviation: NDArray) -> Floats:
    """Return the root mean square of how far L - s and L + s are from L on an sRGB screen, which clips.

    The slope of the curve at L alone would be 13 times s in the dark, however large s is, and nothing where L is white
    but L - s is not.
    """
    middle = encode_srgb(luminance)
    apart = [encode_srgb(luminance + sign * deviation) - middle for sign in (-1, 1)]
    return np.sqrt(0.5 * (apart[0] ** 2 + apart[1] ** 2))


def root_mean_square(values: NDArray, frame: Frame) -> Floats:
    """Return the root of the mean square over colour channels (H, W)."""
    return np.sqrt(np.mean(np.square(values[..., : frame.colour_channels], dtype=np.float64), axis=-1))


def within(deviation: Floats, limit: float) -> float:
    """Return the share of pixels off by no more than ``limit``, for normal errors of standard ``deviation`` (P,)."""
    return float(np.mean(erf(limit / np.maximum(np.sqrt(2.0) * deviation, 1e-300))))


def bound(deviation: Floats, share: float) -> float:
    """Return what ``share`` of the pixels keep within, for normal errors of standard ``deviation`` (P,) >= 0."""
    top = float(deviation.max(initial=0.0))
    if not 0.0 < top < np.inf:
        return top
    low, high = np.log(top) - 60.0, np.log(top) + 3.0
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if within(deviation, float(np.exp(middle))) >= share else (middle, high)
    return float(np.exp(high))
