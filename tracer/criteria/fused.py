"""Geometry as prior and radiance as data, combined by a regression whose coefficients each scene determines.

An allocation needs the error that a pixel's *next* samples will have, and this can be measured: it is how far the mean
of the last round lies from the mean of all samples before it. That is one number per pixel, unbiased and very noisy. So
it is regressed on predictors that were known before the round: the variance of the pixel's samples smoothed over
several widths, the contrast between neighbouring pixels, and that contrast where pilot rays saw an edge of shapes or
faces (for two regions of contrast D the variance in a pixel is exactly D^2 / 2 times the Gini index of its IDs).
Coefficients are not negative and are fitted anew in every round. Where edges dominate they weigh the edges, where noise
is heavy they weigh the smoothest estimate, and where nothing predicts anything only the constant is left, which is
uniform sampling. As the difference of means comes from the real, stratified sequence, predictors of noise that
stratification removes by itself get less weight than their variance suggests.

Stacked regression: L. Breiman, Machine Learning 24, 1996. Complexity of a pixel as the measure of the samples that it
needs: D. Plemenos, M. Sbert and M. Feixas, section 4.4, here with Gini-Simpson in place of Shannon.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from tracer.complexity.pilot import Complexity
from tracer.core.arrays import Floats, Mask, Singles, spread_out
from tracer.core.device import channels_of, to_host, upload
from tracer.core.reductions import sums
from tracer.core.smoothing import box, gaussian, smoothed
from tracer.criteria.registry import Evidence, criterion
from tracer.film.estimate import Statistics

FINE = (0.5, 1.0)
"""Standard deviations, in pixels, of the narrow Gaussians over which variances are smoothed."""
COARSE = (7, 13)
"""Widths, in pixels, of the boxes over which variances are smoothed widely; their deviations are 2 and 3.7 pixels."""
OUTLIER = 30.0
"""A squared difference of means counts at most this many times its prediction, so that no firefly decides the fit."""
ITERATIONS = 4
"""Number of fits in a round, each weighted by the prediction of the one before."""
GUESS_FLOOR = 0.1
"""Deviation that is added to every pixel of a first guess, relative to the mean deviation."""
FIT_PIXELS = 1 << 13
"""Number of pixels, about, that the regression examines; they are evenly spread."""
SMALLEST = 1e-6
"""Least predicted error of a pixel, relative to the mean."""


@criterion("fused", needs_radiance=True, spends="deviation")
def fused(evidence: Evidence) -> Floats:
    """Return the root of the predicted squared error (H, W), weighted by the objective."""
    statistics, before, memory = evidence.statistics, evidence.before, evidence.memory
    assert statistics is not None
    weight = evidence.weight_before
    if before is None or weight is None:
        return first_guess(statistics, evidence)
    edges = memory.get("edges") or smooth_gini(evidence.complexity)
    past = memory.get("predictors") or predictors(before, weight, evidence.colour_channels, edges)
    present = predictors(statistics, evidence.weight, evidence.colour_channels, edges)
    memory.update(edges=edges, predictors=present)
    chosen = np.arange(weight.size, dtype=np.uint32)[spread_out(weight.size, FIT_PIXELS)]
    errors, is_known = error_of_means(before, statistics, weight, evidence.colour_channels, chosen)
    columns = at_pixels(past, chosen)[is_known]
    if len(columns) == 0 or not (np.all(np.isfinite(columns)) and np.all(np.isfinite(errors))):
        return np.ones_like(evidence.weight)
    predicted = combine(present, fit(columns, errors[is_known]))
    least = dr.opaque(mi.Float, SMALLEST * sums(predicted)[0] / weight.size)
    return to_host(dr.sqrt(dr.maximum(predicted, least)), weight.shape).astype(np.float64)


def first_guess(statistics: Statistics, evidence: Evidence) -> Floats:
    """Return a standard deviation (H, W) for rounds without anything to fit: that of a pixel and its neighbours."""
    variance = channel_mean(statistics.variance, evidence.colour_channels) * upload(mi.Float, evidence.weight)
    (smooth,) = smoothed(variance, evidence.weight.shape, gaussian(FINE[-1]))
    deviation = to_host(dr.sqrt(dr.maximum(smooth, 0)), evidence.weight.shape)
    return (deviation + GUESS_FLOOR * deviation.mean()).astype(np.float64)


def error_of_means(
    before: Statistics, statistics: Statistics, weight: Floats, channels: int, pixels: NDArray[np.uint32]
) -> tuple[Floats, Mask]:
    """Return (m_2 - m_1)^2 / (1/n_1 + 1/n_2) of some pixels, and where it is known: (N,) each.

    It is weighted and averaged over colour channels. m_1 is the mean of the n_1 samples before the last round, and m_2
    the mean of the n_2 samples of that round. For independent samples the expectation is the variance of one sample.
    ``pixels`` (N,): which pixels, counted row by row.
    """
    first_count, total_count = (known.count.ravel()[pixels].astype(np.float64) for known in (before, statistics))
    first_mean, total_mean = (
        known.mean.reshape(-1, known.mean.shape[-1])[pixels, :channels].astype(np.float64)
        for known in (before, statistics)
    )
    second_count = total_count - first_count
    is_known = (first_count > 0) & (second_count > 0)
    # m_2 - m_1 from the mean m of all n samples: (m - m_1) n / n_2
    difference = (total_mean - first_mean) * (total_count / np.maximum(second_count, 1))[:, None]
    per_sample = (difference**2).mean(axis=-1) * first_count * second_count / np.maximum(total_count, 1)
    return np.where(is_known, per_sample * weight.ravel()[pixels], 0.0), is_known


def at_pixels(columns: Sequence[Any], pixels: NDArray[np.uint32]) -> Floats:
    """Return K device arrays (mi.Float) at some pixels (N,), as (N, K)."""
    index = upload(mi.UInt32, pixels)
    chosen = [dr.gather(mi.Float, column, index) for column in columns]
    dr.eval(chosen)
    return np.stack([column.numpy() for column in chosen], axis=-1).astype(np.float64)


def combine(columns: Sequence[Any], coefficients: Floats) -> Any:
    """Return the sum (mi.Float) of ``columns``, K of them, times their coefficients (K,)."""
    total = mi.Float(0)
    for column, coefficient in zip(columns, coefficients, strict=True):
        total = dr.fma(column, dr.opaque(mi.Float, coefficient), total)
    return total


def predictors(statistics: Statistics, weight: Floats, channels: int, edges: Sequence[Any]) -> list[Any]:
    """Return the K predictors of the squared error of each pixel, mi.Float each, row by row: variances >= 0.

    ``weight`` (H, W): that of the objective; ``edges``: what ``smooth_gini`` returns.
    """
    height, width = weight.shape
    size, on_device = (height, width), upload(mi.Float, weight)
    variance = channel_mean(statistics.variance, channels) * on_device
    smooth = smoothed(variance, size, *map(gaussian, FINE), *map(box, COARSE))
    mean = dr.opaque(mi.Float, sums(variance)[0] / weight.size)
    noise = smooth[1] / dr.maximum(mi.Float(upload(mi.UInt32, statistics.count)), 1)
    difference = local_variance(channel_mean(statistics.mean, channels), size)
    contrast = dr.maximum(difference * on_device - noise, 0)
    shape, face = edges
    # Contrast times the Gini index of IDs is the variance that the edges seen by pilot rays explain.
    (wide_contrast,) = smoothed(contrast, size, gaussian(1.0))
    found = [*smooth, mean + dr.zeros(mi.Float, weight.size), contrast]
    found += [contrast * shape, contrast * face, wide_contrast * shape]
    dr.eval(found)
    return found


def channel_mean(values: Singles, channels: int) -> Any:
    """Return the mean (mi.Float) over the first ``channels`` channels of ``values`` (H, W, C), row by row."""
    return sum(channels_of(values, channels)) / channels


def smooth_gini(complexity: Complexity) -> list[Any]:
    """Return the Gini indices of shape IDs and of face IDs, mi.Float each, averaged over 3 x 3 neighbours."""
    indices = (complexity.shape_gini, complexity.face_gini)
    return [smoothed(upload(mi.Float, gini), gini.shape, box(3))[0] for gini in indices]


def local_variance(values: Any, size: tuple[int, int]) -> Any:
    """Return the variance (mi.Float) of ``values``, a picture of ``size``, over 3 x 3 neighbours."""
    (mean,), (mean_square,) = (smoothed(array, size, box(3)) for array in (values, dr.square(values)))
    return dr.maximum(mean_square - dr.square(mean), 0)


def fit(past: Floats, observed: Floats) -> Floats:
    """Return the coefficients >= 0 (K,) with which columns of ``past`` (N, K) predict ``observed`` (N,) best.

    They are fitted by least squares in relative terms, as a squared difference scatters in proportion to its
    expectation: each iteration divides by the prediction of the one before. A column of zeros has the coefficient 0.
    """
    scale = past.mean(axis=0)
    says_nothing = scale <= 0
    scale[says_nothing] = 1.0
    columns = past / scale
    prediction = columns.mean(axis=1) * (observed.mean() / max(columns.mean(), 1e-300))
    coefficients = np.zeros(past.shape[1])
    for _ in range(ITERATIONS):
        if not prediction.mean() > 0:  # no error was observed, or no predictor explains it
            break
        level = np.maximum(prediction, 1e-3 * prediction.mean() + 1e-300)
        coefficients = non_negative(columns / level[:, None], np.minimum(observed / level, OUTLIER))
        prediction = columns @ coefficients
    return np.where(says_nothing, 0.0, coefficients / scale)


def non_negative(columns: Floats, target: Floats) -> Floats:
    """Return x >= 0 (K,) that minimises |columns x - target|, with ``columns`` (N, K) and ``target`` (N,).

    It is solved from the normal equations, as N is large and K small. With columns^T columns = R^T R the norm is
    |R x - R^-T columns^T target| up to a constant.
    """
    gram = columns.T @ columns
    gram[np.diag_indices_from(gram)] *= 1.0 + 1e-9
    root = np.linalg.cholesky(gram + 1e-300 * np.eye(len(gram)))
    return nnls(root.T, np.linalg.solve(root, columns.T @ target))[0]
