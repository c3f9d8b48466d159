"""What a denoiser leaves of the noise: the weight of the objective ``denoised``.

Where a denoiser does its work well, samples are wasted; where it blurs, or takes noise for detail, they count. How far
the denoised picture moves from round to round is a measure of the error that it still has, as the picture's own move is
of its noise. The share of noise that is left, (denoised move)^2 / move^2, each smoothed, multiplies the weight of a
pixel's variance. That samples should minimise the error after denoising is the aim of A. Kuznetsov, N. K. Kalantari and
R. Ramamoorthi, "Deep Adaptive Sampling for Low Sample Count Rendering", 2018, who train a network for it.
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
"""For features, per pixel: more would improve what is denoised by a hundredth."""
SMOOTH = 3.0
"""Standard deviation in pixels over which moves are averaged."""
LEAST = 0.02
"""Of a share: below it, it is taken for a denoiser's luck."""


class ResidualNoise:
    """Denoises the means after every round."""

    def __init__(self, view: View, sampler: Any, seed: int) -> None:
        self.view, self.sampler, self.seed = view, sampler, seed
        self.features: Features | None = None
        self.last: tuple[Statistics, NDArray[np.float32]] | None = None
        self.share: Floats | float = 1.0
        """Of squared noise that denoising leaves (grid), LEAST to 1."""

    def update(self, before: Statistics, known: Statistics) -> None:
        """Learn the share from the statistics before and after a round. Raises DenoiseError."""
        inner = self.view.inner
        past, present = self.denoised(before), self.denoised(known)
        noisy = [self.view.rgb(each.mean[inner]) for each in (before, known)]
        weight = objective.weights("relative", gaussian_filter(self.view.luminance(known.mean[inner]), 1.0))
        left = gaussian_filter(weight * np.mean((present - past) ** 2, axis=-1), SMOOTH)
        noise = gaussian_filter(weight * np.mean((noisy[1] - noisy[0]) ** 2, axis=-1), SMOOTH)
        with np.errstate(divide="ignore", invalid="ignore"):  # where nothing is noise the quotient is not chosen
            share = np.where(noise > 0, left / noise, 1.0)
        self.share = np.pad(np.clip(share, LEAST, 1.0), self.view.border, mode="edge")

    def denoised(self, known: Statistics) -> NDArray[np.float32]:
        """Return the means of the picture without noise (H, W, 3); those of the last round are kept."""
        if self.last is not None and self.last[0] is known:
            return self.last[1]
        if self.features is None:
            counts = np.full(self.view.grid, RAYS, np.uint32)  # whenever they are drawn, the same
            self.features = draw_features(self.view, self.sampler, self.seed, counts, RAYS, filtered=False)
        inner, rgb = self.view.inner, self.view.rgb
        values, count = known.mean[inner], known.count[inner]
        mean, own = rgb(values), rgb(own_errors(values, known.variance[inner], count))
        outliers = find_outliers(mean, own, count)
        clean = denoise(taken_out(mean, outliers), self.features.albedo, self.features.normal)
        self.last = known, np.where(outliers.mask[..., None], mean, clean)
        return self.last[1]
