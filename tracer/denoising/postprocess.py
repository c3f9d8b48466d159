"""What is done when all samples of a picture are drawn: compute features of what is seen, and take out the noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from tracer.core.arrays import Singles
from tracer.denoising.blend import blend, errors_of, share_of_noisy
from tracer.denoising.oidn import denoise
from tracer.denoising.outliers import find_outliers, own_errors, taken_out, within_reach
from tracer.denoising.refilter import filter_share, refilter, untold_share
from tracer.film.estimate import PRIOR_RADIUS, Statistics
from tracer.film.features import Features, draw_features, shape_numbers
from tracer.scene.view import View

HEAVY = 2.0
"""Factor for the noise that pixel means do not show: few samples hold much of it, so a mean square understates it."""


@dataclass(frozen=True)
class Seen:
    """Features, filtered like the picture, and the shapes that are seen."""

    features: Features
    """Albedo, normal and depth, filtered like the picture."""
    shapes: NDArray[np.uint32]
    """(H, W): number of the shape in the middle of each pixel, from 1; 0 where nothing is seen."""
    shape_names: list[str]
    """Name of each shape; that of shape number n is at index n - 1."""


def see(view: View, sampler: Any, seed: int, counts: NDArray[np.uint32]) -> Seen:
    """Return what is seen along the rays of a picture that has ``counts`` (grid) samples of ``seed``."""
    return Seen(draw_features(view, sampler, seed, counts), *shape_numbers(view))


def without_noise(
    view: View, sampler: Any, seed: int, image: Singles, stderr: Singles, statistics: Statistics, scale: float | None
) -> Singles:
    """Return a picture (H, W, C) with its colours denoised where that helps; alpha and AOVs stay. Raises DenoiseError.

    The denoiser gets the mean of each pixel's own samples, as through the film's filter neighbours share noise, which a
    denoiser takes for detail. The filter is imitated afterwards. The imitation does not know where in a pixel the light
    is; the detail that it misses comes from the picture. Outliers stay as they were. ``stderr``: standard errors of the
    picture (H, W, C); ``scale``: their measured factor, or None.
    """
    features = draw_features(view, sampler, seed, statistics.count, filtered=False)
    inner, colours, rfilter = view.inner, view.colour_channels, view.film.rfilter()
    count = statistics.count[inner]
    values = np.where(count[..., None] > 0, statistics.mean[inner], image)[..., :colours]
    own_squares = np.maximum(view.rgb(own_errors(values, statistics.variance[inner][..., :colours], count)), 0.0)
    noisy, mean = view.rgb(image), view.rgb(values)
    outliers = find_outliers(mean, own_squares, count)
    calm = taken_out(mean, outliers)
    clean, plain = (refilter(picture, rfilter) for picture in (denoise(calm, features.albedo, features.normal), calm))
    stays = within_reach(mean, noisy, outliers, view.reach)
    telling = ~maximum_filter(stays, 2 * PRIOR_RADIUS + 1)  # standard errors nearer than this depend on what stays
    error = np.maximum(view.rgb(stderr), 0.0)
    errors = errors_of(clean, error, own_squares * filter_share(rfilter), scale, outliers.certain, telling)
    detail = noisy - plain
    untold = min(HEAVY * untold_share(rfilter), 1.0)
    denoised = clean + share_of_noisy(detail, errors, untold) * detail
    mixed = np.where(stays[..., None], noisy, blend(noisy, denoised, errors))
    return np.concatenate([view.from_rgb(mixed), image[..., colours:]], axis=-1).astype(np.float32)
