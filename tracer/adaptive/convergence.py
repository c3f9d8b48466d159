"""How noisy a picture still is: the error that a given share of its pixels keeps within.

The error of a pixel is that of the exposed picture. For ``relative`` it is the part of the pixel's brightness by which
the pixel is off (of 0.1 if the pixel is darker), for ``display`` a difference on an sRGB screen from 0 to 1, for
``absolute`` radiance times 2^exposure. Over colour channels it is the root of the mean square. Alpha is judged as well
if the picture has it: its error is the part of full cover by which it is off, whatever the exposure, and a pixel is off
by the larger of the two errors. AOVs are not judged, and nothing is denoised before.

The estimate has two sources. The standard errors tell how errors are distributed over the picture, but a stratified
sequence errs by less, and rare light by more. The move of the picture in a round is a measurement: while counts double,
the mean moves by as much, in standard deviation, as it is still off. So the quantile of the move is compared with the
quantile that standard errors predict for it, and the ratio is applied to the error that is left. A ratio that rises
from round to round, as while rare light is being discovered, is taken to go on rising.
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
"""Number of pixels, about, that are examined; they are evenly spread."""
STEPS = 60
"""Steps of the bisection that finds the logarithm of an error."""
LEAST_GROWTH = 1.5
"""Factor by which the samples must grow before the move of the picture is measured again: if few pixels get samples,
hardly any pixel moves. From 26 to 32 samples per pixel the estimate was a quarter of the true error."""
TREND_POWER, MOST_TREND = 1.5, 2.0
"""A factor by which the ratio rises in a round is expected again, raised to TREND_POWER but at most MOST_TREND. On the
bundled scenes this leaves few predictions too low, as those at which a render stops tend to be."""


@dataclass(frozen=True)
class Noise:
    """What is known of the error after a round."""

    error: float
    """Error that ``noise_share`` of the pixels are estimated to keep within."""
    converged: float | None
    """Share of the pixels that are estimated to be within the target; None without a target."""
    needed: float
    """Factor of the samples drawn that meets the target, if squared error ~ 1 / samples; 1 if the target is met."""
    measured: bool
    """Whether a move of the picture was measured; if not, the estimate comes from standard errors alone."""


@dataclass
class NoiseMeter:
    """Estimates the noise of a picture, which it follows from round to round."""

    image: NDArray[np.float32] | None = None
    """(H, W, C): the picture when its move was last measured; None before the first round."""
    count: NDArray[np.uint32] | None = None
    """(H, W): samples of each pixel when the move was last measured."""
    factor: float | None = None
    """Ratio of measured to predicted move, when it was last measured."""
    scale: float | None = None
    """Factor by which standard errors are multiplied; None as long as no move was measured."""
    counted: NDArray[np.bool_] | None = None
    """(H, W): pixels that count; None: all of them."""

    def follow(
        self,
        frame: Frame,
        settings: Settings,
        image: NDArray[np.float32],
        stderr: NDArray[np.float32],
        count: NDArray[np.uint32],
    ) -> None:
        """Note the picture (H, W, C) after a round, with its standard errors (H, W, C) and counts (H, W).

        A short round tells nothing, so it is passed over: the next move is measured from the picture before it.
        """
        if self.count is not None and count.sum(dtype=np.float64) < LEAST_GROWTH * self.count.sum(dtype=np.float64):
            return
        if self.image is not None and self.count is not None:
            moved = self.some(errors(frame, settings, image, image - self.image))
            present_count, earlier_count = (
                uniform_filter(counts.astype(np.float64), 3, mode="nearest") for counts in (count, self.count)
            )
            growth = np.maximum(present_count / np.maximum(earlier_count, 1e-9) - 1.0, 0.0)
            expected = self.some(errors(frame, settings, image, stderr * np.sqrt(growth)[..., None]))
            predicted = bound(expected, settings.noise_share)
            factor = float(np.quantile(moved, settings.noise_share)) / predicted if predicted > 0 else 1.0
            trend = factor / self.factor if self.factor else 1.0
            self.factor, self.scale = factor, factor * min(max(trend, 1.0) ** TREND_POWER, MOST_TREND)
        self.image, self.count = image, count

    def look(self, frame: Frame, settings: Settings, image: NDArray[np.float32], stderr: NDArray[np.float32]) -> Noise:
        """Return the noise of a picture (H, W, C) with its standard errors (H, W, C)."""
        scale = 1.0 if self.scale is None else self.scale
        deviation = scale * self.some(errors(frame, settings, image, stderr))
        error, target = bound(deviation, settings.noise_share), settings.noise
        converged, needed = (None, 1.0) if target is None else (within(deviation, target), (error / target) ** 2)
        return Noise(error, converged, max(needed, 1.0), self.scale is not None)

    def some(self, values: Floats) -> Floats:
        """Return the values (P,) of about LOOKED_AT of the pixels that count, from the values of all pixels (H, W)."""
        counted_values = values.ravel() if self.counted is None else values[self.counted]
        return counted_values[spread_out(counted_values.size, LOOKED_AT)]


def errors(frame: Frame, settings: Settings, image: NDArray, deviation: NDArray) -> Floats:
    """Return the errors (H, W) of a picture's pixels (H, W, C) whose channels are off by ``deviation`` (H, W, C)."""
    luminance, colour = frame.luminance(image), root_mean_square(deviation, frame)
    colour_error = seen(settings.objective, settings.exposure, luminance, colour)
    if not frame.has_alpha:
        return colour_error
    return np.maximum(colour_error, np.abs(deviation[..., frame.colour_channels]))


def seen(name: str, exposure: float, luminance: NDArray, deviation: NDArray) -> Floats:
    """Return the errors (H, W) by an objective of pixels of mean ``luminance`` (H, W) that are off by ``deviation``."""
    if name == "display":
        return on_screen(luminance * 2.0**exposure, deviation * 2.0**exposure)
    return np.sqrt(objective.weights(name, luminance, exposure)) * deviation


def on_screen(luminance: NDArray, deviation: NDArray) -> Floats:
    """Return the root mean square distance of L - s and L + s from L on an sRGB screen, which clips; all (H, W).

    L is the luminance and s the deviation. The slope of the curve at L alone would make it 13 s in the dark, however
    large s is, and 0 where L is white but L - s is not.
    """
    middle = encode_srgb(luminance)
    distances = [encode_srgb(luminance + sign * deviation) - middle for sign in (-1, 1)]
    return np.sqrt(0.5 * (distances[0] ** 2 + distances[1] ** 2))


def root_mean_square(values: NDArray, frame: Frame) -> Floats:
    """Return the root mean square (H, W) over the colour channels of ``values`` (H, W, C)."""
    return np.sqrt(np.mean(np.square(values[..., : frame.colour_channels], dtype=np.float64), axis=-1))


def within(deviation: Floats, limit: float) -> float:
    """Return the share of pixels off by at most ``limit``, for normal errors of standard ``deviation`` (P,)."""
    return float(np.mean(erf(limit / np.maximum(np.sqrt(2.0) * deviation, 1e-300))))


def bound(deviation: Floats, share: float) -> float:
    """Return the error that ``share`` of pixels keep within, for normal errors of standard ``deviation`` (P,) >= 0."""
    top = float(deviation.max(initial=0.0))
    if not 0.0 < top < np.inf:
        return top
    low, high = np.log(top) - 60.0, np.log(top) + 3.0
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if within(deviation, float(np.exp(middle))) >= share else (middle, high)
    return float(np.exp(high))
