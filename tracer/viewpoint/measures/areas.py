"""Measures of projected areas alone."""

from __future__ import annotations

import numpy as np

from tracer.complexity import measures
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.observation import Sight


@measure("visible", "most")
def visible(sight: Sight) -> float:
    """Return how many surfaces are seen, each counted with its weight."""
    return float(sight.weights.sum())


@measure("projected_area", "most")
def projected_area(sight: Sight) -> float:
    """Return a_t as a share of the image, 0 to 1; surfaces are counted with their weights."""
    return float(sight.weighted.sum()) / sight.image_area


@measure("viewpoint_complexity", "most")
def viewpoint_complexity(sight: Sight) -> float:
    """Return C(V) of the paper (section 3.1), 0 to 2: the shares of surfaces seen and of the image covered, added.

    Surfaces are counted with their weights.
    """
    total_weight = float(sight.subject.weights.sum())
    return (visible(sight) / total_weight if total_weight > 0 else 0.0) + projected_area(sight)


@measure("visibility_ratio", "most", "areas")
def visibility_ratio(sight: Sight) -> float:
    """Return the true area of the surfaces that are seen as a share of that of all surfaces, 0 to 1.

    Areas are counted with the weights of their surfaces.
    """
    areas = sight.subject.areas * sight.subject.weights
    total_area = float(areas.sum())
    return float(areas[sight.surfaces].sum()) / total_area if total_area > 0 else 0.0


@measure("entropy", "most")
def entropy(sight: Sight) -> float:
    """Return the viewpoint entropy H in bits (the paper, section 3.1), the background included if it counts.

    With weights it is the weighted entropy -sum w p log2 p, in which the background has the weight 1.
    """
    areas, weights = sight.projected, sight.weights
    if sight.background:
        areas, weights = np.append(areas, max(sight.image_area - sight.total, 0.0)), np.append(weights, 1.0)
    return float(measures.weighted_entropy(areas, weights))


@measure("kullback_leibler", "least", "areas")
def kullback_leibler(sight: Sight) -> float:
    """Return the divergence in bits of p(z|v) from the shares of true area: 0 if all is seen in proportion to its area.

    M. Sbert, D. Plemenos, M. Feixas and F. Gonzalez, "Viewpoint quality: measures and applications", CAe 2005.
    With weights, shares of area times weight are expected; surfaces of weight 0 are left out. It is infinite if nothing
    is seen that counts.
    """
    expected = sight.subject.areas * sight.subject.weights
    return max(divergence(sight, expected), 0.0)  # a value below 0 comes from rounding


def divergence(sight: Sight, expected: np.ndarray) -> float:
    """Return sum p(z|v) log2(p(z|v) / q(z)) in bits over the surfaces z that are expected: ``expected`` (Z,) > 0.

    p(z|v) are the shares of the projected area of all surfaces of weight > 0, so that a view is not the better the more
    it shows of what does not count; q are the shares of ``expected``, which is 0 for surfaces of weight 0. The result
    is infinite if no expected surface is seen.
    """
    is_expected = expected[sight.surfaces] > 0
    if not is_expected.any():
        return float("inf")
    p = sight.projected[is_expected] / sight.projected[sight.weights > 0].sum()
    q = expected[sight.surfaces[is_expected]] / expected.sum()
    return float(np.sum(p * np.log2(p / q)))
