"""Entropy and related measures: pure functions of counts and values.

Logarithms are to base 2 unless said otherwise, as in the paper this project comes from (Plemenos, Sbert and Feixas,
"On viewpoint complexity of 3D scenes", section 3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tracer.core.arrays import Floats


def probabilities(counts: ArrayLike) -> Floats:
    """Return counts divided by their sum over the last axis; zeros where the sum is zero. Shape (..., K)."""
    counts = np.asarray(counts, np.float64)
    if np.any(counts < 0):
        raise ValueError("counts must not be negative")
    total = counts.sum(axis=-1, keepdims=True)
    return np.divide(counts, total, out=np.zeros_like(counts), where=total > 0)


def entropy(counts: ArrayLike) -> Floats:
    """Return Shannon's entropy in bits of counts or areas (..., K): 0 to log2 K; 0 where nothing was counted."""
    p = probabilities(counts)
    return -np.sum(p * np.log2(p, out=np.zeros_like(p), where=p > 0), axis=-1) + 0.0


def weighted_entropy(counts: ArrayLike, weights: ArrayLike) -> Floats:
    """Return -sum w p log2 p in bits of counts or areas (..., K) with weights w >= 0 (..., K); 0 where nothing counts.

    With all weights 1 it is Shannon's entropy. S. Guiasu, "Weighted entropy", Reports on Mathematical Physics 2(3),
    1971.
    """
    p = probabilities(counts)
    logs = p * np.log2(p, out=np.zeros_like(p), where=p > 0)
    return -np.sum(np.asarray(weights, np.float64) * logs, axis=-1) + 0.0


def gini(counts: ArrayLike) -> Floats:
    """Return the Gini-Simpson index 1 - sum p^2 of counts (..., K): 0 to 1 - 1/K; 0 where nothing was counted."""
    p = probabilities(counts)
    return np.where(p.sum(axis=-1) > 0, 1.0 - np.sum(p * p, axis=-1), 0.0)


def tsallis(counts: ArrayLike, index: float) -> Floats:
    """Return the Tsallis (Havrda-Charvat) entropy (1 - sum p^q) / (q - 1), nats in the limit q = 1."""
    if index == 1:
        return entropy(counts) * np.log(2)
    p = probabilities(counts)
    powers = np.power(p, index, out=np.zeros_like(p), where=p > 0)
    return np.where(p.sum(axis=-1) > 0, (1.0 - powers.sum(axis=-1)) / (index - 1.0), 0.0)


def renyi(counts: ArrayLike, order: float) -> Floats:
    """Return the Renyi entropy log2(sum p^a) / (1 - a) in bits, Shannon's in the limit a = 1."""
    if order == 1:
        return entropy(counts)
    p = probabilities(counts)
    powers = np.power(p, order, out=np.zeros_like(p), where=p > 0).sum(axis=-1)
    return np.log2(powers, out=np.zeros_like(powers), where=powers > 0) / (1.0 - order) + 0.0


def contrast(values: ArrayLike) -> Floats:
    """Return 1 - H / log K of values >= 0 (..., K): 0 if all are equal (even if all are 0), 1 if a single one is not 0.

    Equations 7 and 10 of J. Rigau, M. Feixas and M. Sbert, "Entropy-based adaptive sampling", Graphics Interface 2003.
    """
    values = np.asarray(values, np.float64)
    return kullback_leibler(values) / np.log(max(values.shape[-1], 2))


def kullback_leibler(values: ArrayLike) -> Floats:
    """Return the divergence ln K - H in nats of values >= 0 (..., K), as shares of their sum, from uniform shares.

    This measure and the next two are from J. Rigau, M. Feixas and M. Sbert, "Refinement criteria based on
    f-divergences", EGSR 2003. All three are 0 where all values are 0.
    """
    values = np.asarray(values, np.float64)
    divergence = np.log(values.shape[-1]) - entropy(values) * np.log(2)
    return np.where(values.sum(axis=-1) > 0, np.maximum(divergence, 0.0), 0.0)


def chi_square(values: ArrayLike) -> Floats:
    """Return K sum p^2 - 1 of values >= 0 (..., K): their squared deviation from the mean over the squared mean."""
    p = probabilities(values)
    return np.maximum(p.shape[-1] * np.sum(p * p, axis=-1) - 1.0, 0.0)


def hellinger(values: ArrayLike) -> Floats:
    """Return 1 - sum sqrt(p / K), half the squared distance of sqrt(p) from sqrt(1 / K), of values >= 0 (..., K)."""
    p = probabilities(values)
    return np.where(p.sum(axis=-1) > 0, np.maximum(1.0 - np.sqrt(p / p.shape[-1]).sum(axis=-1), 0.0), 0.0)


def viewpoint_complexity(areas: ArrayLike, surfaces: int, image_area: float) -> Floats:
    """Return C(V) = (1/n) sum ceil(P_i / (P_i + 1)) + (1/r) sum P_i, in (0, 2] (the paper, section 3.1).

    ``areas`` (..., K): projected area P_i of each surface, background excluded, in the unit of ``image_area`` = r.
    ``surfaces`` = n: number of surfaces of the scene. The first term is the share of surfaces that are visible; the
    printed formula lacks the brackets of the ceiling, which the paper's text explains.
    """
    areas = np.asarray(areas, np.float64)
    return np.count_nonzero(areas > 0, axis=-1) / surfaces + areas.sum(axis=-1) / image_area


def shares(multiplicity: ArrayLike) -> Floats:
    """Return p_j = m_j / K of K rays (..., K); m_j is the number of these rays that hit the same thing as ray j."""
    multiplicity = np.asarray(multiplicity, np.float64)
    return multiplicity / multiplicity.shape[-1]


def ray_mean(values: Floats) -> Floats:
    """Return the mean over the last axis, K rays. For few rays this product is ten times as fast as NumPy's mean."""
    return values @ np.full(values.shape[-1], 1.0 / values.shape[-1])


def ray_entropy(multiplicity: ArrayLike) -> Floats:
    """Return the entropy in bits of what K rays hit, H = -(1/K) sum_j log2(m_j / K); see ``shares``."""
    return -ray_mean(np.log2(shares(multiplicity))) + 0.0


def ray_viewpoint(multiplicity: ArrayLike, hit: ArrayLike, surfaces: int) -> Floats:
    """Return ``viewpoint_complexity`` C(V) of an image of K rays.

    ``multiplicity`` (..., K): as for ``shares``; ``hit`` (..., K): whether each ray hits a surface; ``surfaces``:
    number of surfaces of the scene.
    """
    hit = np.asarray(hit, bool)
    visible = np.rint(np.where(hit, 1.0 / np.asarray(multiplicity, np.float64), 0.0).sum(axis=-1))
    return visible / max(surfaces, 1) + hit.mean(axis=-1)


def ray_gini(multiplicity: ArrayLike) -> Floats:
    """Return the Gini-Simpson index of what K rays hit, 1 - (1/K) sum_j m_j / K; see ``shares``."""
    return 1.0 - ray_mean(shares(multiplicity))


def ray_distinct(multiplicity: ArrayLike) -> Floats:
    """Return how many different things K rays hit, sum_j 1 / m_j."""
    return np.rint((1.0 / np.asarray(multiplicity, np.float64)).sum(axis=-1))
