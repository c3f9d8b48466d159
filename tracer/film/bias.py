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
from numpy.typing import NDArray

from tracer.core.arrays import Singles
from tracer.core.device import to_host, upload
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
        drawn = statistics.count.astype(np.float32)
        if before is not None:
            drawn -= before.count
        weight = weights(drawn) + self.waiting
        gained = weight * (drawn > 0)
        # The sum of gained x mean of the round, as ``round_means`` has it, in fewer steps over the picture.
        part = gained * (statistics.count / np.maximum(drawn, 1)).astype(np.float32)
        total = part[..., None] * statistics.mean
        total += self.total
        if before is not None:
            total += (gained - part)[..., None] * before.mean
        return UnbiasedMean(total, self.weight + gained, weight - gained)

    def closed(self, before: Statistics | None, statistics: Statistics, chance: Singles | None) -> UnbiasedMean:
        """Return the mean after the last round, in which no weight is left waiting.

        ``chance`` (H, W): the chance that a pixel had of a sample in that round; None if nothing was left to chance. A
        pixel without a sample in that round counts with its mean before it.
        """
        mean, drawn = round_means(before, statistics)
        if before is not None:
            times = np.where(drawn > 0, 1 if chance is None else 1 / np.maximum(chance, 1e-3), 0)
            mean = before.mean + times[..., None].astype(np.float32) * (mean - before.mean)
        weight = weights(drawn) + self.waiting
        return UnbiasedMean(self.total + weight[..., None] * mean, self.weight + weight, np.zeros_like(weight))

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
        return self.total / self.weight[..., None] - statistics.mean


def mean_at_the_end(
    unbiased: UnbiasedMean, before: Statistics | None, statistics: Statistics, chance: Singles | None, is_whole: bool
) -> UnbiasedMean:
    """Return the mean over all rounds. ``is_whole``: whether the last round was finished, rather than stopped.

    ``unbiased``: the mean over the rounds before the last; for the other arguments see ``UnbiasedMean.closed``.
    """
    return unbiased.closed(before, statistics, chance) if is_whole else unbiased.given_up(statistics)


def round_means(before: Statistics | None, statistics: Statistics) -> tuple[Singles, Singles]:
    """Return the mean (H, W, C) and the number (H, W) of the samples of a round; 0 where there are none."""
    if before is None:
        return statistics.mean, statistics.count.astype(np.float32)
    drawn = statistics.count.astype(np.float32) - before.count
    share = np.where(drawn > 0, statistics.count / np.maximum(drawn, 1), 0).astype(np.float32)
    mean = before.mean + (statistics.mean - before.mean) * share[..., None]
    return np.where(drawn[..., None] > 0, mean, 0), drawn


def weights(drawn: Singles) -> Singles:
    """Return the weight of a round for each pixel (H, W): its mean number of samples around, without the nearest."""
    height, width = drawn.shape
    kernels = box(AROUND), box(NEXT_TO)
    wide, near = smoothed(upload(mi.Float, drawn), (height, width), *kernels, beyond="mirror")
    around = dr.maximum(wide * AROUND**2 - near * NEXT_TO**2, 0) / (AROUND**2 - NEXT_TO**2)
    return to_host(around + dr.opaque(mi.Float, 1e-3 * drawn.mean()), drawn.shape)


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
    brightness = np.abs(image)
    noise = NOISY * stderr
    share = noise * brightness / np.maximum(noise + brightness, np.float32(1e-30))
    total_share = share.sum(axis=(0, 1), dtype=np.float64)
    part = missing.sum(axis=(0, 1), dtype=np.float64) / np.where(total_share > 0, total_share, 1)
    part = np.where(np.isfinite(part) & (total_share > 0), part, 0)
    part = np.clip(part * trusted(missing[..., :colours].sum(axis=-1, dtype=np.float64)), -MOST, MOST)
    part[colours:] = 0
    return np.where(np.isfinite(share), share * part, 0).astype(np.float32)


def trusted(missing: NDArray[np.float64]) -> float:
    """Return the part of the sum of ``missing`` (H, W) that is taken to be true, 0 to 1.

    With the sum m and its standard error e, estimated from the spread of the pixels, it is m^2 / (m^2 + e^2): the
    factor that gives a measurement of m with that error the least mean square error. Without it the picture would only
    become noisier where there is hardly a bias to measure, as after many samples or in a small picture.
    """
    if not np.all(np.isfinite(missing)):
        return 0.0
    total, error = missing.sum(), missing.std() * np.sqrt(missing.size)
    return float(total**2 / (total**2 + error**2)) if total else 0.0


def with_lost_light(
    frame: Frame, image: Singles, stderr: Singles, statistics: Statistics, unbiased: UnbiasedMean | None
) -> Singles:
    """Return a picture (H, W, C) with the light that decisions have lost; as it is if ``unbiased`` is None."""
    if unbiased is None:
        return image
    return image + lost_light(image, stderr, unbiased.above(statistics)[frame.inner], frame.colour_channels)


def part_of(lost: Singles, image: Singles, colours: int) -> float:
    """Return the mean of the light that was lost over the mean of the picture; 0 for a black picture."""
    mean = float(image[..., :colours].mean(dtype=np.float64))
    return float(lost[..., :colours].mean(dtype=np.float64)) / mean if mean else 0.0
