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

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, uniform_filter
from scipy.optimize import nnls

from tracer.complexity.pilot import Complexity
from tracer.core.arrays import Floats, Singles, spread_out
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
    observed, valid = error_of_means(before, statistics, weight, evidence.colour_channels)
    chosen = np.flatnonzero(valid)[spread_out(valid.size, FIT_PIXELS)]
    columns = np.stack([column.ravel()[chosen] for column in past], axis=-1).astype(np.float64)
    errors = observed.ravel()[chosen]
    if len(chosen) == 0 or not (np.all(np.isfinite(columns)) and np.all(np.isfinite(errors))):
        return np.ones_like(evidence.weight)
    predicted = combine(present, fit(columns, errors))
    return np.sqrt(np.maximum(predicted, SMALLEST * predicted.mean()))


def first_guess(statistics: Statistics, evidence: Evidence) -> Floats:
    """Return a standard deviation (H, W) for rounds without anything to fit: that of a pixel and its neighbours."""
    variance = channel_mean(statistics.variance, evidence.colour_channels) * evidence.weight.astype(np.float32)
    deviation = np.sqrt(np.maximum(gaussian_filter(variance, FINE[-1], mode="nearest"), 0))
    return (deviation + GUESS_FLOOR * deviation.mean()).astype(np.float64)


def error_of_means(
    before: Statistics, statistics: Statistics, weight: Floats, channels: int
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return (m_2 - m_1)^2 / (1/n_1 + 1/n_2), weighted and averaged over colour channels, and where it is known.

    m_1 is the mean of the n_1 samples before the last round, and m_2 the mean of the n_2 samples of that round. For
    independent samples the expectation is the variance of one sample.
    """
    first_count, total_count = before.count.astype(np.float32), statistics.count.astype(np.float32)
    second_count = total_count - first_count
    valid = (first_count > 0) & (second_count > 0)
    # m_2 - m_1 from the mean m of all n samples: (m - m_1) n / n_2
    squared = (
        channel_mean((statistics.mean - before.mean) ** 2, channels) * (total_count / np.maximum(second_count, 1)) ** 2
    )
    per_sample = squared * first_count * second_count / np.maximum(total_count, 1)
    return np.where(valid, per_sample * weight, 0.0), valid


def combine(columns: list[Singles], coefficients: Floats) -> Floats:
    """Return the sum (H, W) of ``columns``, (H, W) each, times their coefficients (K,)."""
    total = np.zeros(columns[0].shape)
    for column, coefficient in zip(columns, coefficients, strict=True):
        if coefficient > 0:
            total += coefficient * column
    return total


def predictors(statistics: Statistics, weight: Floats, channels: int, edges: Sequence[Singles]) -> list[Singles]:
    """Return the K predictors of the squared error of each pixel, (H, W) each: variances >= 0.

    ``weight`` (H, W): that of the objective; ``edges``: what ``smooth_gini`` returns.
    """
    weight = weight.astype(np.float32)
    variance = channel_mean(statistics.variance, channels) * weight
    fine = [gaussian_filter(variance, deviation, mode="nearest") for deviation in FINE]
    coarse = [uniform_filter(variance, width, mode="nearest") for width in COARSE]
    difference = local_variance(channel_mean(statistics.mean, channels))
    noise = fine[-1] / np.maximum(statistics.count, 1).astype(np.float32)
    contrast = np.maximum(difference * weight - noise, 0.0)
    shape, face = edges
    # Contrast times the Gini index of IDs is the variance that the edges seen by pilot rays explain.
    explained = [contrast * shape, contrast * face, gaussian_filter(contrast, 1.0, mode="nearest") * shape]
    return [*fine, *coarse, np.full_like(variance, variance.mean()), contrast, *explained]


def channel_mean(values: NDArray, channels: int) -> Singles:
    """Return the mean (H, W) over the first ``channels`` channels of ``values`` (H, W, C)."""
    total = values[..., 0].copy()
    for k in range(1, channels):
        total += values[..., k]
    return (total / channels).astype(np.float32)


def smooth_gini(complexity: Complexity) -> list[Singles]:
    """Return the Gini indices of shape IDs and of face IDs, (H, W) each, averaged over 3 x 3 neighbours."""
    indices = (complexity.shape_gini, complexity.face_gini)
    return [uniform_filter(gini.astype(np.float32), 3, mode="nearest") for gini in indices]


def local_variance(values: Singles) -> Singles:
    """Return the variance (H, W) of ``values`` (H, W) over 3 x 3 neighbours."""
    mean = uniform_filter(values, 3, mode="nearest")
    return np.maximum(uniform_filter(values**2, 3, mode="nearest") - mean**2, 0.0)


def fit(past: Floats, observed: Floats) -> Floats:
    """Return the coefficients >= 0 (K,) with which columns of ``past`` (N, K) predict ``observed`` (N,) best.

    They are fitted by least squares in relative terms, as a squared difference scatters in proportion to its
    expectation: each iteration divides by the prediction of the one before.
    """
    scale = past.mean(axis=0)
    scale[scale <= 0] = 1.0
    columns = past / scale
    prediction = columns.mean(axis=1) * (observed.mean() / max(columns.mean(), 1e-300))
    coefficients = np.zeros(past.shape[1])
    for _ in range(ITERATIONS):
        if not prediction.mean() > 0:  # no error was observed, or no predictor explains it
            break
        level = np.maximum(prediction, 1e-3 * prediction.mean() + 1e-300)
        coefficients = non_negative(columns / level[:, None], np.minimum(observed / level, OUTLIER))
        prediction = columns @ coefficients
    return coefficients / scale


def non_negative(columns: Floats, target: Floats) -> Floats:
    """Return x >= 0 (K,) that minimises |columns x - target|, with ``columns`` (N, K) and ``target`` (N,).

    It is solved from the normal equations, as N is large and K small. With columns^T columns = R^T R the norm is
    |R x - R^-T columns^T target| up to a constant.
    """
    gram = columns.T @ columns
    gram[np.diag_indices_from(gram)] *= 1.0 + 1e-9
    root = np.linalg.cholesky(gram + 1e-300 * np.eye(len(gram)))
    return nnls(root.T, np.linalg.solve(root, columns.T @ target))[0]
