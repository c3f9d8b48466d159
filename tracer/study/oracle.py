"""The oracle: the best allocation for known errors of all pixels, and the most that any allocation can gain."""

from __future__ import annotations

import mitsuba as mi
import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import gaussian_filter

from tracer.adaptive import budget
from tracer.adaptive.convergence import on_screen
from tracer.core.arrays import Floats
from tracer.core.device import to_host, upload
from tracer.image import colour, objective
from tracer.study.oracle_measurements import Truth

LEAST_LIMIT = 1.1
"""Limit of the gain below which there is so little to gain that the share captured of it means nothing."""
RATES = (0.7, 2.0)
"""Least and largest b of e(n) = a n^-b: b is 1 for independent samples, and up to 2 for smooth integrands."""
FINE, WIDE = 0.7, 3.0
"""Standard deviations, in pixels, of the Gaussians that smooth a and b: a variance over a few seeds is noisy."""
LEAST = 1e-4
"""Least error of a pixel, relative to the mean: a pixel without error in any seed still needs a sample or two."""
LEAST_SHOWN = 1 / 8
"""Least samples of a pixel for the objective ``display``, relative to the mean: the display clips a pixel whose mean is
above white, but its noise still reaches below white and shows."""
STEPS = 60
"""Number of bisections that find the lambda with which the budget is spent."""


def limit(variance: ArrayLike, mean: ArrayLike, name: str) -> float:
    """Return the most that an allocation can gain with equal samples, 1 + CV^2 of s sqrt(w) (Neyman, 1934).

    ``variance`` of one sample and ``mean`` are (H, W, 3); s is the standard deviation of one sample, and w the weight
    of the objective ``name``. This holds for independent samples, and if a pixel may have any number of them; a
    low-discrepancy sequence can gain less or more.
    """
    weight = objective.weights(name, colour.luminance(mean))
    deviation = np.sqrt(np.asarray(variance, np.float64).sum(axis=-1) * weight)
    average = float(deviation.mean())
    return float(np.mean(deviation**2)) / average**2 if average > 0 else 1.0


def share(gain: float, most: float) -> float | None:
    """Return log(gain) / log(most), the captured share of the limit ``most``; None if there is next to no limit."""
    return float(np.log(gain) / np.log(most)) if most > LEAST_LIMIT and gain > 0 else None


def fit(truth: Truth) -> tuple[Floats, Floats]:
    """Return a and b (H, W) of the error e(n) = a n^-b of every pixel, from the errors measured at several n."""
    x = np.log(truth.counts.astype(np.float64))
    error = truth.squared_error.astype(np.float64)
    floor = LEAST * error.mean(axis=(1, 2), keepdims=True) + 1e-300
    wide = np.log(np.stack([gaussian_filter(values, WIDE, mode="nearest") for values in error]) + floor)
    slope = np.tensordot(x - x.mean(), wide, axes=(0, 0)) / np.sum((x - x.mean()) ** 2)
    rate = np.clip(-slope, *RATES)
    fine = np.stack([gaussian_filter(values, FINE, mode="nearest") for values in error]) + floor
    # Each n gives an estimate a = e n^b; the estimates are averaged, weighted by their degrees of freedom.
    scale = np.stack([values * count**rate for values, count in zip(fine, truth.counts, strict=True)])
    return np.average(scale, axis=0, weights=truth.seeds - 1), rate


def allocation(truth: Truth, name: str, spp: float, by: str, least: float = 1.0) -> Floats:
    """Return the samples n of each pixel (H, W), at least ``least``, that minimise the sum of w a n^-b for a budget.

    ``by`` "samples": the budget is a mean of ``spp`` samples; "time": the time of ``spp`` samples of every pixel.
    Setting the derivative to zero gives n = (w a b / (lambda c))^(1 / (1 + b)) with c = 1 or the cost of a sample;
    lambda is the number with which the budget is spent. ``name`` is the objective, whose weight is w.
    """
    scale, rate = fit(truth)
    luminance = gaussian_filter(truth.luminance.astype(np.float64), FINE, mode="nearest")
    weight = objective.weights(name, luminance)
    if name == "display":
        least = max(least, LEAST_SHOWN * spp)
        weight = secant(luminance, np.sqrt(scale * least**-rate))
    cost = truth.cost.astype(np.float64) if by == "time" else np.ones_like(scale)
    urgency = weight * scale * rate / cost
    if not urgency.max() > 0:
        return np.full(scale.shape, float(spp))
    urgency /= urgency.max()
    low, high = -80.0, 80.0
    counts = np.full(scale.shape, float(spp))
    for _ in range(STEPS):
        middle = (low + high) / 2
        counts = np.maximum((urgency * np.exp(middle)) ** (1 / (1 + rate)), least)
        low, high = (middle, high) if np.sum(counts * cost) < spp * np.sum(cost) else (low, middle)
    return counts


def secant(luminance: Floats, noise: Floats) -> Floats:
    """Return the mean of the squared slopes of the sRGB curve from L - s to L and from L to L + s, with clipping.

    ``luminance`` L and its ``noise`` s are (H, W), linear; where s is zero the result is zero.
    """
    squared = on_screen(luminance, noise) ** 2
    return np.divide(squared, noise**2, out=np.zeros_like(squared), where=noise > 0)


def rendered_allocation(truth: Truth, name: str, spp: float, by: str) -> Floats:
    """Return ``allocation`` in counts that suit the sequence of samples, with a mean that is a whole number."""
    counts = allocation(truth, name, spp, by)
    total = max(1, round(float(counts.mean()))) * counts.size
    target = upload(mi.Float64, counts * (total / counts.sum()))
    return to_host(budget.suit_sequence(target, total, 1.0, float(total)), counts.shape)
