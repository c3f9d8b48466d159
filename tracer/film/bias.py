"""The light that deciding loses, measured and given back.

Pixels that look dark by chance get fewer samples and stay dark, those that look bright get more and lose what was
chance: a picture whose samples also decided is too dark, by half a percent at 16 samples per pixel of a Cornell box,
and by two where light is rare. That cannot be mended pixel by pixel without giving up what adapting gains, as much of
that is the very dilution of what was bright by chance. It can be measured, though. The samples of a round, by
themselves, err to no side, however many there are, so a mean over rounds whose weights do not depend on the pixel's own
samples has no bias. It is noisy in every pixel, and precise over all of them. What it is above the picture's mean, in
all, is shared out in proportion to brightness where the picture is noisy.

The weight of a round is the mean count of the pixels around, without those next to the pixel, as the pixel's own
samples steer theirs. A round in which a pixel had no sample gives its weight to the next in which it has one. Every
pixel has a chance of a sample in every round, and one that has it by chance in the last counts for all that went
without (D. G. Horvitz and D. J. Thompson, "A Generalization of Sampling Without Replacement From a Finite Universe",
1952). Rounds of a sequence of low discrepancy are not quite independent of each other; what is left of the bias for
that reason is in ``results/bias``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from tracer.core.arrays import Singles
from tracer.film.estimate import Statistics
from tracer.scene.frame import Frame

AROUND, NEXT_TO = 13, 5
"""Sides in pixels of the square over whose pixels a round is weighed, and of the one in its middle that is left out."""
CHANCE, LEAST_CHANCE = 0.5, 1 / 16
"""Chance of a sample in a round for a pixel of mean importance, in proportion to it, and the least of any."""
SHARE_BY_CHANCE = 8
"""A pixel that has samples by chance has at least one, and one for so many that it has already."""
NOISY = 10.0
"""Pixels of a standard error well above this part of their brightness (1 / NOISY) take light in proportion to
brightness, others to their standard error."""
MOST = 0.05
"""Largest part of a pixel's brightness that is given or taken: no single rare sample may brighten a whole picture."""


@dataclass
class UnbiasedMean:
    """Mean of each pixel over rounds that are weighed without regard to the pixel's own samples."""

    total: Singles
    """(H, W, C): sum of weight x mean of a round."""
    weight: Singles
    """(H, W): sum of weights."""
    waiting: Singles
    """(H, W): weights of rounds without a sample, for the next round with one."""

    @classmethod
    def nothing(cls, size: tuple[int, int], channels: int) -> UnbiasedMean:
        """Return the mean before the first round."""
        return cls(np.zeros((*size, channels), np.float32), np.zeros(size, np.float32), np.zeros(size, np.float32))

    def after(self, before: Statistics | None, known: Statistics) -> UnbiasedMean:
        """Return the mean after another round; ``before`` and ``known``: statistics before and after that round."""
        own, drawn = round_means(before, known)
        weight = weights(drawn) + self.waiting
        gained = weight * (drawn > 0)
        return UnbiasedMean(self.total + gained[..., None] * own, self.weight + gained, weight - gained)

    def closed(self, before: Statistics | None, known: Statistics, chance: Singles | None) -> UnbiasedMean:
        """Return the mean after the last round, in which no weight is left waiting.

        ``chance`` (H, W): with which a pixel had a sample in that round; None where that was not left to chance. A
        pixel without a sample counts as it was before.
        """
        own, drawn = round_means(before, known)
        if before is not None:
            often = np.where(drawn > 0, 1 if chance is None else 1 / np.maximum(chance, 1e-3), 0)
            own = before.mean + often[..., None].astype(np.float32) * (own - before.mean)
        weight = weights(drawn) + self.waiting
        return UnbiasedMean(self.total + weight[..., None] * own, self.weight + weight, np.zeros_like(weight))

    def given_up(self, known: Statistics) -> UnbiasedMean:
        """Return the mean of a render that is stopped within a round, where ``known`` is what there is."""
        return UnbiasedMean(
            self.total + self.waiting[..., None] * known.mean, self.weight + self.waiting, np.zeros_like(self.waiting)
        )

    def merged(self, other: UnbiasedMean) -> UnbiasedMean:
        """Return the mean over the rounds of both, which are of different samples."""
        return UnbiasedMean(self.total + other.total, self.weight + other.weight, self.waiting + other.waiting)

    def above(self, known: Statistics) -> Singles:
        """Return what this mean is above the plain mean of each pixel's samples (H, W, C); 0 if all counts agree."""
        if np.ptp(known.count) == 0:
            return np.zeros_like(known.mean)
        return self.total / self.weight[..., None] - known.mean


def mean_at_the_end(
    unbiased: UnbiasedMean, before: Statistics | None, known: Statistics, chance: Singles | None, is_whole: bool
) -> UnbiasedMean:
    """Return the mean over all rounds, the last one too if it ``is_whole``; else the render was stopped within it.

    ``unbiased``: over the rounds before the last; for the other arguments see ``UnbiasedMean.closed``.
    """
    return unbiased.closed(before, known, chance) if is_whole else unbiased.given_up(known)


def round_means(before: Statistics | None, known: Statistics) -> tuple[Singles, Singles]:
    """Return the mean (H, W, C) and number (H, W) of the samples of a round; 0 where there is none."""
    if before is None:
        return known.mean, known.count.astype(np.float32)
    drawn = known.count.astype(np.float32) - before.count
    share = np.where(drawn > 0, known.count / np.maximum(drawn, 1), 0).astype(np.float32)
    own = before.mean + (known.mean - before.mean) * share[..., None]
    return np.where(drawn[..., None] > 0, own, 0), drawn


def weights(drawn: Singles) -> Singles:
    """Return the weight of a round for each pixel (H, W): the mean number of samples around it, without those near."""
    wide, near = (uniform_filter(drawn, side, mode="mirror") * side**2 for side in (AROUND, NEXT_TO))
    around = np.maximum(wide - near, 0) / (AROUND**2 - NEXT_TO**2)
    return (around + 1e-3 * drawn.mean()).astype(np.float32)


def chances(importance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the chance of each pixel (H, W) to have a sample in a round, if it has none for its importance."""
    mean = importance.mean()
    relative = importance / mean if mean > 0 else np.ones_like(importance)
    return np.clip(CHANCE * relative, LEAST_CHANCE, 1.0)


def samples_by_chance(drawn: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """Return how many samples pixels (H, W) that have ``drawn`` have by chance: a part, or noise would not fall."""
    return np.maximum(drawn // SHARE_BY_CHANCE, 1).astype(np.uint32)


def lost_light(image: Singles, stderr: Singles, missing: Singles, colours: int) -> Singles:
    """Return what is to be added to a picture (H, W, C) of standard errors ``stderr``, so that its mean is right.

    ``missing`` (H, W, C): what each pixel's unbiased mean is above its own, very noisy. The sum of what is returned is
    that of ``missing`` in each of the first ``colours`` channels, as far as it is ``trusted`` and MOST allows; 0 in
    others.
    """
    brightness = np.abs(image)
    noise = NOISY * stderr
    share = noise * brightness / np.maximum(noise + brightness, np.float32(1e-30))
    whole = share.sum(axis=(0, 1), dtype=np.float64)
    part = missing.sum(axis=(0, 1), dtype=np.float64) / np.where(whole > 0, whole, 1)
    part = np.where(np.isfinite(part) & (whole > 0), part, 0)
    part = np.clip(part * trusted(missing[..., :colours].sum(axis=-1, dtype=np.float64)), -MOST, MOST)
    part[colours:] = 0
    return np.where(np.isfinite(share), share * part, 0).astype(np.float32)


def trusted(missing: NDArray[np.float64]) -> float:
    """Return the part of the sum of ``missing`` (H, W) that is taken to be true, 0 to 1.

    With the sum m and its standard error e, from how far pixels are apart, m^2 / (m^2 + e^2): the factor by which a
    measurement of m with that error has the least mean square error. Where there is hardly a bias to be measured, as
    after many samples or in a small picture, the picture would only become noisier.
    """
    if not np.all(np.isfinite(missing)):
        return 0.0
    whole, error = missing.sum(), missing.std() * np.sqrt(missing.size)
    return float(whole**2 / (whole**2 + error**2)) if whole else 0.0


def with_lost_light(
    frame: Frame, image: Singles, stderr: Singles, known: Statistics, unbiased: UnbiasedMean | None
) -> Singles:
    """Return a picture (H, W, C) with the light that deciding has lost; as it is where ``unbiased`` is None."""
    if unbiased is None:
        return image
    return image + lost_light(image, stderr, unbiased.above(known)[frame.inner], frame.colour_channels)


def part_of(lost: Singles, image: Singles, colours: int) -> float:
    """Return the mean of what was lost as a part of the mean of the picture it was lost from; 0 of a black one."""
    mean = float(image[..., :colours].mean(dtype=np.float64))
    return float(lost[..., :colours].mean(dtype=np.float64)) / mean if mean else 0.0
