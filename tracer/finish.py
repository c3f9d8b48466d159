"""What is made of a picture when all its samples are drawn: features of what is seen, and the picture without noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.blend import blend
from tracer.denoise import denoise
from tracer.estimate import Statistics
from tracer.features import Features, draw_features, shape_numbers
from tracer.refilter import filter_share, refilter
from tracer.scene import View

Singles = NDArray[np.float32]


@dataclass(frozen=True)
class Seen:
    """Features, filtered as the picture is, and which shapes are seen."""

    features: Features
    shapes: NDArray[np.uint32]
    """(H, W): number of the shape in the middle of each pixel, from 1; 0 for nothing."""
    shape_names: list[str]


def see(view: View, sampler: Any, seed: int, counts: NDArray[np.uint32]) -> Seen:
    """Return what is seen along the rays of a picture that has ``counts`` (grid) samples of ``seed``."""
    return Seen(draw_features(view, sampler, seed, counts), *shape_numbers(view))


def without_noise(
    view: View, sampler: Any, seed: int, image: Singles, stderr: Singles, known: Statistics, scale: float | None
) -> Singles:
    """Return a picture (H, W, C) with its colours denoised where that helps; alpha and AOVs stay. Raises DenoiseError.

    Denoised is the mean of each pixel's own samples: through the film's filter neighbours share noise, and a denoiser
    takes what they share for detail. The filter is made up for afterwards. ``stderr``: standard errors of the picture,
    to be multiplied by ``scale`` if that was measured.
    """
    features = draw_features(view, sampler, seed, known.count, filtered=False)
    inner, colours = view.inner, view.colour_channels
    means = np.where(known.count[inner][..., None] > 0, known.mean[inner], image)[..., :colours]
    clean = denoise(view.rgb(means), features.albedo, features.normal)
    clean = refilter(clean, view.film.rfilter())
    error = np.maximum(view.rgb(stderr), 0.0)
    own = known.variance[inner] / np.maximum(known.count[inner], 1)[..., None]
    own = np.maximum(view.rgb(own), 0.0) * filter_share(view.film.rfilter())
    clean = blend(view.rgb(image), clean, error, own, scale)
    return np.concatenate([view.from_rgb(clean), image[..., colours:]], axis=-1).astype(np.float32)
