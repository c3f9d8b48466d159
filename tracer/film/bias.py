"""The light that adaptive decisions lose, measured and given back.

Pixels that look dark by chance get fewer samples and stay dark; pixels that look bright by chance get more samples,
which dilute the chance. So a picture whose samples also decided is too dark: by half a percent at 16 samples per pixel
of a Cornell box, and by two percent where light is rare. This cannot be mended pixel by pixel without giving up what
adapting gains, as much of the gain is this very dilution. But it can be measured. The samples of one round by
themselves have no bias, however many there are, so neither has a mean over rounds whose weights do not depend on the
pixel's own samples. This mean is noisy in each pixel and precise over all of them. Its excess over the picture's mean,
summed over the picture, is distributed in proportion to brightness where the picture is noisy.

The weight of a round is the mean count of the pixels around, without the nearest, as the pixel's own samples steer
their counts. A round in which a pixel had no sample passes its weight on to the next round in which the pixel has one.
Every pixel has a chance of a sample in every round, and a pixel that has one by chance in the last round counts for all
that had none (D. G. Horvitz and D. J. Thompson, "A Generalization of Sampling Without Replacement From a Finite
Universe", 1952). Rounds of a sequence of low discrepancy are not quite independent of each other; the bias that is left
for that reason is in ``results/bias``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core import parallel
from tracer.core.arrays import Singles
from tracer.core.device import channels_of, divide, interleave, to_host, upload
from tracer.core.reductions import sums
from tracer.core.smoothing import box, smoothed
from tracer.film.estimate import Statistics
from tracer.scene.frame import Frame

AROUND, NEXT_TO = 13, 5
"""AROUND: side in pixels of the square around a pixel whose mean count is the weight of a round. NEXT_TO: side of the
square in its middle that is left out."""
CHANCE, LEAST_CHANCE = 0.5, 1 / 16
"""CHANCE: chance of a sample in a round for a pixel of mean importance; it is proportional to importance. LEAST_CHANCE:
least chance of any pixel."""
SHARE_BY_CHANCE = 8
"""A pixel that gets samples by chance gets one for this many samples that it already has, and at least one."""
NOISY = 10.0
"""Pixels whose standard error is well above 1 / NOISY of their brightness are given light in proportion to brightness;
others in proportion to their standard error."""
MOST = 0.05
"""Largest part of a pixel's brightness that is added or removed, so that no rare sample brightens a whole picture."""


@dataclass
class UnbiasedMean:
    """Mean of each pixel over rounds whose weights do not depend on the pixel's own samples."""

    total: Singles
    """(H, W, C): sum over rounds of weight x mean of the round."""
    weight: Singles
    """(H, W): sum of the weights of rounds."""
    waiting: Singles
    """(H, W): weights of past rounds without a sample in the pixel, which the next round with a sample takes over."""

    @classmethod
    def nothing(cls, size: tuple[int, int], channels: int) -> UnbiasedMean:
        """Return the mean before the first round, of a picture of ``size`` (height, width)."""
        return cls(np.zeros((*size, channels), np.float32), np.zeros(size, np.float32), np.zeros(size, np.float32))

    def after(self, before: Statistics | None, statistics: Statistics) -> UnbiasedMean:
        """Return the mean after another round; ``before`` and ``statistics``: before and after that round."""
        count, drawn = counts_of_round(before, statistics)
        weight = weights(drawn, self.weight.shape) + upload(mi.Float, self.waiting)
        gained = dr.select(drawn > 0, weight, 0)
        # gained x mean of the round, as (n m - n' m') / (n - n') from counts and means after and before it
        part = gained * count / dr.maximum(drawn, 1)
        return self.with_round(before, statistics, part, gained - part, gained, weight - gained)

    def closed(self, before: Statistics | None, statistics: Statistics, chance: Singles | None) -> UnbiasedMean:
        """Return the mean after the last round, in which no weight is left waiting.

        ``chance`` (H, W): the chance that a pixel had of a sample in that round; None if nothing was left to chance. A
        pixel without a sample in that round counts with its mean before it.
        """
        count, drawn = counts_of_round(before, statistics)
        weight = weights(drawn, self.weight.shape) + upload(mi.Float, self.waiting)
        part = weight
        if before is not None:
            times = 1 if chance is None else dr.rcp(dr.maximum(upload(mi.Float, chance), 1e-3))
            part = weight * dr.select(drawn > 0, times * count / dr.maximum(drawn, 1), 0)
        return self.with_round(before, statistics, part, weight - part, weight, dr.zeros(mi.Float, dr.width(weight)))

    def with_round(
        self, before: Statistics | None, statistics: Statistics, part: Any, part_before: Any, gained: Any, waiting: Any
    ) -> UnbiasedMean:
        """Return the sums with ``part`` times the means of ``statistics`` and ``part_before`` times those before it.

        ``gained`` is added to the weight, and ``waiting`` takes the place of what waits. All are mi.Float, one entry
        for each pixel.
        """
        dr.eval(part, part_before, gained, waiting)
        pixel = divide(dr.arange(mi.UInt32, self.total.size), self.total.shape[-1])[0]
        total = dr.fma(
            dr.gather(mi.Float, part, pixel), upload(mi.Float, statistics.mean), upload(mi.Float, self.total)
        )
        if before is not None:
            total = dr.fma(dr.gather(mi.Float, part_before, pixel), upload(mi.Float, before.mean), total)
        size = self.weight.shape
        return UnbiasedMean(
            to_host(total, self.total.shape), self.weight + to_host(gained, size), to_host(waiting, size)
        )

    def given_up(self, statistics: Statistics) -> UnbiasedMean:
        """Return the mean of a render that is stopped within a round; ``statistics``: those when it stops."""
        return UnbiasedMean(
            self.total + self.waiting[..., None] * statistics.mean,
            self.weight + self.waiting,
            np.zeros_like(self.waiting),
        )

    def merged(self, other_mean: UnbiasedMean) -> UnbiasedMean:
        """Return the mean over the rounds of two renders of different samples."""
        return UnbiasedMean(
            self.total + other_mean.total, self.weight + other_mean.weight, self.waiting + other_mean.waiting
        )

    def above(self, statistics: Statistics) -> Singles:
        """Return this mean minus the plain mean of each pixel's samples (H, W, C); 0 if all counts are equal."""
        if np.ptp(statistics.count) == 0:
            return np.zeros_like(statistics.mean)
        return parallel.fill(np.empty_like(self.total), excess, self.total, self.weight, statistics.mean)


def excess(total: Singles, weight: Singles, mean: Singles) -> Singles:
    """Return ``total`` (H, W, C) per ``weight`` (H, W), minus ``mean`` (H, W, C)."""
    return total / weight[..., None] - mean


def mean_at_the_end(
    unbiased: UnbiasedMean, before: Statistics | None, statistics: Statistics, chance: Singles | None, is_whole: bool
) -> UnbiasedMean:
    """Return the mean over all rounds. ``is_whole``: whether the last round was finished, rather than stopped.

    ``unbiased``: the mean over the rounds before the last; for the other arguments see ``UnbiasedMean.closed``.
    """
    return unbiased.closed(before, statistics, chance) if is_whole else unbiased.given_up(statistics)


def counts_of_round(before: Statistics | None, statistics: Statistics) -> tuple[Any, Any]:
    """Return the number of samples after a round and of those drawn in it, mi.Float each, row by row."""
    count = upload(mi.Float, statistics.count)
    return count, count if before is None else count - upload(mi.Float, before.count)


def weights(drawn: Any, size: tuple[int, ...]) -> Any:
    """Return the weight of a round for each pixel: its mean number of samples around, without the nearest.

    ``drawn``: how many samples each pixel had in it; a picture of ``size`` (height, width), row by row. Both are
    mi.Float.
    """
    height, width = size
    wide, near = smoothed(drawn, (height, width), box(AROUND), box(NEXT_TO), beyond="mirror")
    around = dr.maximum(wide * AROUND**2 - near * NEXT_TO**2, 0) / (AROUND**2 - NEXT_TO**2)
    return around + dr.opaque(mi.Float, 1e-3 * sums(drawn)[0] / dr.width(drawn))


def chances(importance: Any) -> Any:
    """Return the chance of each pixel of a sample in a round in which its importance brings it none (mi.Float64)."""
    mean = sums(importance)[0] / dr.width(importance)
    if not mean > 0:
        return dr.full(mi.Float64, CHANCE, dr.width(importance))
    return dr.clip(importance * dr.opaque(mi.Float64, CHANCE / mean), LEAST_CHANCE, 1.0)


def samples_by_chance(drawn: Any) -> Any:
    """Return how many samples pixels get by chance: a part of those ``drawn``, or their noise would not fall.

    Both are mi.UInt32.
    """
    return dr.maximum(drawn // SHARE_BY_CHANCE, 1)


def lost_light(image: Singles, stderr: Singles, missing: Singles, colours: int) -> Singles:
    """Return the light to add to a picture (H, W, C) with standard errors ``stderr``, so that its mean is right.

    ``missing`` (H, W, C): each pixel's unbiased mean minus its own mean, very noisy. In each of the first ``colours``
    channels the returned light has the sum of ``missing``, as far as that is ``trusted`` and MOST allows; it is 0 in
    the other channels.
    """
    brightness, errors, lacking = (channels_of(values, colours) for values in (image, stderr, missing))
    shares = [share_of_light(dr.abs(value), NOISY * error) for value, error in zip(brightness, errors, strict=True)]
    trust = trusted(sum(map(mi.Float64, lacking)))
    lights = []
    for share, share_sum, lacking_sum in zip(shares, sums(*shares), sums(*lacking), strict=True):
        part = lacking_sum * trust / share_sum if 0 < share_sum < np.inf and trust > 0 else 0.0
        light = share * dr.opaque(mi.Float, np.clip(part, -MOST, MOST))
        lights.append(dr.select(dr.isfinite(share), light, 0))
    lost = dr.empty(mi.Float, image.size)
    interleave(lost, [*lights, *[mi.Float(0)] * (image.shape[-1] - colours)], dr.arange(mi.UInt32, dr.width(lights[0])))
    return to_host(lost, image.shape)


def share_of_light(brightness: Any, noise: Any) -> Any:
    """Return what a pixel gets of the light that was lost, relative to others: about the smaller of both (mi.Float)."""
    return noise * brightness / dr.maximum(noise + brightness, 1e-30)


def trusted(missing: Any) -> float:
    """Return the part of the sum of ``missing`` (mi.Float64) that is taken to be true, 0 to 1.

    With the sum m and its standard error e, estimated from the spread of the pixels, it is m^2 / (m^2 + e^2): the
    factor that gives a measurement of m with that error the least mean square error. Without it the picture would only
    become noisier where there is hardly a bias to measure, as after many samples or in a small picture.
    """
    total, square_sum = sums(missing, dr.square(missing))
    if total == 0 or not np.isfinite(square_sum):
        return 0.0
    error_square = max(square_sum - total**2 / dr.width(missing), 0.0)
    return total**2 / (total**2 + error_square)


def with_lost_light(
    frame: Frame, image: Singles, stderr: Singles, statistics: Statistics, unbiased: UnbiasedMean | None
) -> Singles:
    """Return a picture (H, W, C) with the light that decisions have lost; as it is if ``unbiased`` is None."""
    if unbiased is None:
        return image
    lost = lost_light(image, stderr, unbiased.above(statistics)[frame.inner], frame.colour_channels)
    return parallel.fill(lost, np.add, image, lost)


def light_added(bright: Singles, image: Singles, colours: int) -> float:
    """Return by which part of its mean a picture (H, W, C) is brighter than ``image``; 0 if that is black."""
    means = [float(picture[..., :colours].mean(dtype=np.float64)) for picture in (bright, image)]
    return means[0] / means[1] - 1.0 if means[1] else 0.0
