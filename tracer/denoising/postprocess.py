"""What is done when all samples of a picture are drawn: compute features of what is seen, and take out the noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Singles
from tracer.denoising.mixture import Pictures, mixture
from tracer.denoising.noise import own_errors
from tracer.denoising.oidn import denoise
from tracer.denoising.refilter import FilterShape
from tracer.film.estimate import Statistics
from tracer.film.features import Features, draw_features, shape_numbers
from tracer.scene.frame import Frame
from tracer.scene.view import View

FEATURE_RAYS = 8
"""Rays per pixel of the features that denoising needs: with 32 the squared error of denoised pictures falls by 1 %."""


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


def draw_denoising_features(view: View, sampler: Any, seed: int) -> Features:
    """Return the features, each pixel by itself, that ``without_noise`` needs, whatever samples the picture has."""
    counts = np.full(view.grid, FEATURE_RAYS, np.uint32)
    return draw_features(view, sampler, seed, counts, FEATURE_RAYS, filtered=False)


def without_noise(
    frame: Frame, shape: FilterShape, features: Features, image: Singles, statistics: Statistics
) -> Singles:
    """Return a picture (H, W, C) with its colours denoised where that helps; alpha and AOVs stay. Raises DenoiseError.

    ``shape``: of the film's filter; ``features``: what ``draw_denoising_features`` returned.
    """
    inner, colours = frame.inner, frame.colour_channels
    count = statistics.count[inner].astype(np.float32)
    values = statistics.mean[inner][..., :colours].copy()
    values[count == 0] = image[count == 0][:, :colours]
    # Errors of colours that are sums of others are taken to have the same sign.
    errors = frame.rgb(np.sqrt(own_errors(values, statistics.variance[inner][..., :colours], count)))
    noisy, mean = (np.asarray(frame.rgb(picture), np.float32) for picture in (image, values))
    clean = denoise(mean, features.albedo, features.normal)
    squared_errors = np.square(np.asarray(errors, np.float32))
    mixed = mixture(Pictures(noisy, mean, squared_errors, clean, count), shape)
    return np.concatenate([frame.from_rgb(mixed), image[..., colours:]], axis=-1).astype(np.float32)
