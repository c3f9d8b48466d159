"""The picture that is made of a noisy one and its denoised means: noise is taken out where it is noise.

The denoiser gets the mean of each pixel's own samples, as through the film's filter neighbours share noise, which a
denoiser takes for detail. The filter is imitated afterwards. The imitation does not know where in a pixel the light is.
The part of the noisy picture that it misses is called the detail; it holds noise as well. So the picture is the sum of
three: the denoised means, what was taken from them, and the detail, the last two as far as they are no noise. What is
beside glare stays as it was drawn.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from tracer.core import backend
from tracer.core.arrays import Singles, spread_out
from tracer.denoising.glare import find_glare, is_certain
from tracer.denoising.noise import edge_share, expected_noise, possible_ratio
from tracer.denoising.refilter import FilterShape, filtered_variance, refilter
from tracer.denoising.trust import kept_share

STRIP = 128
"""Rows that are worked on at once. Strips are shared out among threads, whose number changes no picture; other strips
would change it by rounding."""
LOOKED_AT = 1 << 16
"""Number of pixels, about, that tell how bright a picture is; they are evenly spread."""
BRIGHT = 0.8
"""Share of the pixels of a picture that are darker than its brighter pixels; fewer than the rest may glare."""
HALO = 8
"""Rows above and below that a row depends on, beyond what the film's filter reaches."""
LARGEST = 1e15
"""Largest brightness that is looked at: squares of more are beyond single precision."""


@dataclass(frozen=True)
class Pictures:
    """What is known of some rows of a picture."""

    noisy: Singles
    """(H, W, 3): the picture as it was drawn, through the film's filter."""
    mean: Singles
    """(H, W, 3): means of each pixel's own samples."""
    squared_errors: Singles
    """(H, W, 3): those of the means, from each pixel's own samples alone."""
    clean: Singles
    """(H, W, 3): the means, denoised."""
    count: Singles
    """(H, W): samples."""

    def rows(self, first: int, last: int) -> Pictures:
        """Return what is known of the rows from ``first`` to before ``last``."""
        return Pictures(*(picture[first:last] for picture in vars(self).values()))


@dataclass(frozen=True)
class Typical:
    """How bright a picture is as a whole."""

    median: float
    """Of its pixels."""
    bright: float
    """That of the brighter pixels: BRIGHT of all pixels are darker."""


def mixture(pictures: Pictures, shape: FilterShape) -> Singles:
    """Return the picture (H, W, 3) that is nearest to the truth by all that is known.

    ``shape``: of the film's filter.
    """
    height = len(pictures.count)
    grey_means = grey(pictures.mean, LARGEST).ravel()
    typical = Typical(*np.quantile(grey_means[spread_out(grey_means.size, LOOKED_AT)], (0.5, BRIGHT)).tolist())
    halo = HALO + shape.reach
    result = np.empty_like(pictures.noisy)

    def mix(first: int) -> None:
        last, above = min(first + STRIP, height), min(halo, first)
        part = mixed_rows(pictures.rows(first - above, min(last + halo, height)), shape, typical)
        result[first:last] = part[above : above + last - first]

    with ThreadPoolExecutor(backend.thread_count()) as threads:
        list(threads.map(mix, range(0, height, STRIP)))
    return result


def mixed_rows(rows: Pictures, shape: FilterShape, typical: Typical) -> Singles:
    """Return the mixture (H, W, 3) of some rows. ``typical``: brightness of the whole picture."""
    grey_mean, grey_clean = grey(rows.mean, LARGEST), grey(rows.clean, LARGEST)
    grey_error = grey(rows.squared_errors, LARGEST**2)
    noise = expected_noise(grey_mean, grey_clean, grey_error, rows.count, typical.median)
    ratio = possible_ratio(rows.count, edge_share(grey_clean, noise, rows.count))
    taken = rows.mean - rows.clean
    taken *= kept_share(taken, noise, ratio, rows.count, grey_clean)[..., None]
    result = refilter(rows.clean + taken, shape)
    if shape.hidden_share > 0.0:
        detail = rows.noisy - refilter(rows.mean, shape)
        detail_noise = np.float32(shape.hidden_share) * filtered_variance(noise, shape)
        result += kept_share(detail, detail_noise, ratio, rows.count, grey_clean)[..., None] * detail
    certain = is_certain(grey_mean, grey_error, rows.count)
    glare = find_glare(grey(rows.noisy, LARGEST), certain, typical.bright)
    result[glare] = rows.noisy[glare]
    # What was given back of too bright noise can be more than there is.
    return np.maximum(result, np.minimum(rows.noisy, np.float32(0)), out=result)


def grey(picture: Singles, largest: float) -> Singles:
    """Return the mean over colours (H, W) of a picture (H, W, 3), or ``largest`` where that is less."""
    mean: Singles = np.minimum(np.einsum("hwc->hw", picture) / np.float32(3), np.float32(largest))
    return mean
