"""The share of noise that a denoiser leaves, which is the weight of the objective ``denoised``.

Where a denoiser works well, samples are wasted; where it blurs or takes noise for detail, they count. The move of the
denoised picture from round to round measures the error that it still has, as the move of the noisy picture measures its
noise. The share of noise that is left, (move of the denoised picture)^2 / (move of the noisy one)^2, both smoothed,
multiplies the weight of a pixel's variance. To minimise the error after denoising is the aim of A. Kuznetsov, N. K.
Kalantari and R. Ramamoorthi, "Deep Adaptive Sampling for Low Sample Count Rendering", 2018, who train a network for it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from tracer.core.arrays import Floats
from tracer.denoising.oidn import denoise
from tracer.denoising.outliers import find_outliers, own_errors, taken_out
from tracer.film.estimate import Statistics
from tracer.film.features import Features, draw_features
from tracer.image import objective
from tracer.scene.view import View

RAYS = 8
"""Rays per pixel for features: more would improve the denoised picture by a hundredth."""
SMOOTH = 3.0
"""Standard deviation in pixels of the Gaussian over which squared moves are averaged."""
LEAST = 0.02
"""Least share: a smaller one is taken to be the denoiser's luck."""


class ResidualNoise:
    """Measures the share of noise that a denoiser leaves, from the denoised means after every round."""

    def __init__(self, view: View, sampler: Any, seed: int) -> None:
        self.view, self.sampler, self.seed = view, sampler, seed
        self.features: Features | None = None
        self.last: tuple[Statistics, NDArray[np.float32]] | None = None
        self.share: Floats | float = 1.0
        """Share of the squared noise that denoising leaves (grid), LEAST to 1; 1.0 before the first round."""

    def update(self, before: Statistics, latest: Statistics) -> None:
        """Measure the share from the statistics ``before`` and after (``latest``) a round. Raises DenoiseError."""
        inner = self.view.inner
        past, present = self.denoised(before), self.denoised(latest)
        noisy = [self.view.rgb(statistics.mean[inner]) for statistics in (before, latest)]
        weight = objective.weights("relative", gaussian_filter(self.view.luminance(latest.mean[inner]), 1.0))
        residue = gaussian_filter(weight * np.mean((present - past) ** 2, axis=-1), SMOOTH)
        noise = gaussian_filter(weight * np.mean((noisy[1] - noisy[0]) ** 2, axis=-1), SMOOTH)
        with np.errstate(divide="ignore", invalid="ignore"):  # where there is no noise, the quotient is not used
            share = np.where(noise > 0, residue / noise, 1.0)
        self.share = np.pad(np.clip(share, LEAST, 1.0), self.view.border, mode="edge")

    def denoised(self, statistics: Statistics) -> NDArray[np.float32]:
        """Return the denoised means of the picture (H, W, 3); those of the last call are kept for the next one."""
        if self.last is not None and self.last[0] is statistics:
            return self.last[1]
        if self.features is None:
            counts = np.full(self.view.grid, RAYS, np.uint32)  # the same at whatever round they are drawn
            self.features = draw_features(self.view, self.sampler, self.seed, counts, RAYS, filtered=False)
        inner, rgb = self.view.inner, self.view.rgb
        values, count = statistics.mean[inner], statistics.count[inner]
        mean, own_squares = rgb(values), rgb(own_errors(values, statistics.variance[inner], count))
        outliers = find_outliers(mean, own_squares, count)
        clean = denoise(taken_out(mean, outliers), self.features.albedo, self.features.normal)
        self.last = statistics, np.where(outliers.mask[..., None], mean, clean)
        return self.last[1]
