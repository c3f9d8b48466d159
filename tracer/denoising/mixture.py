"""The picture that is made of a noisy one and its denoised means: noise is taken out where it is noise.

The denoiser gets the mean of each pixel's own samples, as through the film's filter neighbours share noise, which a
denoiser takes for detail. The filter is imitated afterwards. The imitation does not know where in a pixel the light is:
what it misses is the detail, noise and all. So the picture is the sum of three: the denoised means, what was taken from
them, and the detail, the last two as far as they are no noise. What is beside glare stays as it was drawn.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracer.core import backend
from tracer.core.arrays import Singles, spread_out
from tracer.denoising.glare import find_glare, is_certain
from tracer.denoising.noise import edge_share, expected_noise, possible_ratio
from tracer.denoising.refilter import FilterShape, filtered_variance, refilter
from tracer.denoising.trust import kept_share
from tracer.image.colour import LUMINANCE

STRIP = 128
"""Rows that are worked on at once; strips are shared out among threads, and their number changes no picture."""
LOOKED_AT = 1 << 16
"""Number of pixels, about, whose median is taken; they are evenly spread."""
REACH = 8
"""Rows above and below that a row depends on, beyond what the film's filter reaches."""


@dataclass(frozen=True)
class Pictures:
    """What is known of some rows of a picture."""

    noisy: Singles
    """(H, W, 3): the picture as it was drawn, through the film's filter."""
    mean: Singles
    """(H, W, 3): means of each pixel's own samples."""
    own: Singles
    """(H, W, 3): their squared errors, from each pixel's own samples alone."""
    clean: Singles
    """(H, W, 3): the means, denoised."""
    count: Singles
    """(H, W): samples."""

    def rows(self, first: int, last: int) -> Pictures:
        """Return what is known of the rows from ``first`` to before ``last``."""
        return Pictures(*(picture[first:last] for picture in vars(self).values()))


def mixture(pictures: Pictures, shape: FilterShape) -> Singles:
    """Return the picture (H, W, 3) that is nearest to the truth by all that is known.

    ``shape``: of the film's filter.
    """
    height = len(pictures.count)
    grey_means = grey(pictures.mean).ravel()
    median = float(np.median(grey_means[spread_out(grey_means.size, LOOKED_AT)]))
    halo = REACH + shape.reach
    result = np.empty_like(pictures.noisy)

    def mix(first: int) -> None:
        last, above = min(first + STRIP, height), min(halo, first)
        part = mixed_rows(pictures.rows(first - above, min(last + halo, height)), shape, median)
        result[first:last] = part[above : above + last - first]

    with ThreadPoolExecutor(backend.thread_count()) as threads:
        list(threads.map(mix, range(0, height, STRIP)))
    return result


def mixed_rows(rows: Pictures, shape: FilterShape, median: float) -> Singles:
    """Return the mixture (H, W, 3) of some rows. ``median``: brightness of the whole picture."""
    grey_mean, grey_clean, grey_own = grey(rows.mean), grey(rows.clean), np.maximum(grey(rows.own), 0.0)
    noise = expected_noise(grey_mean, grey_clean, grey_own, rows.count, median)
    ratio = possible_ratio(rows.count, edge_share(grey_clean, noise, rows.count))
    taken = rows.mean - rows.clean
    taken *= kept_share(taken, noise, ratio, rows.count)[..., None]
    result = refilter(rows.clean + taken, shape)
    if shape.untold > 0.0:
        detail = rows.noisy - refilter(rows.mean, shape)
        untold = np.float32(shape.untold) * filtered_variance(noise, shape)
        result += kept_share(detail, untold, ratio, rows.count)[..., None] * detail
    stays = find_glare(rows.noisy @ LUMINANCE.astype(np.float32), is_certain(grey_mean, grey_own, rows.count), median)
    result[stays] = rows.noisy[stays]
    return result


def grey(picture: NDArray) -> Singles:
    """Return the mean over colours (H, W) of a picture (H, W, 3)."""
    mean: Singles = np.einsum("hwc->hw", picture) / np.float32(3)
    return mean
