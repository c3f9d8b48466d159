"""How much a view differs from those beside it."""

from __future__ import annotations

import bz2

import numpy as np
from numpy.typing import NDArray

from tracer.complexity import measures
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.observation import Sight

SIMILAR = 0.87
"""Two depth images are alike if their normalised compression distance is below this."""
SIDE = 64
"""Depth images are reduced to this many pixels a side before they are compressed."""


@measure("instability", "least", "neighbours")
def instability(sight: Sight) -> float:
    """Return the mean Jensen-Shannon divergence in bits between this view and those beside it, weighted by area.

    M. Feixas, M. Sbert and F. Gonzalez, 2009, section 4.2. The value is 0 without neighbours, and 1, the worst, if
    nothing is seen. A surface of twice the weight counts as one of twice the area.
    """
    if sight.weighted.sum() == 0:
        return 1.0
    return (
        float(np.mean([jensen_shannon(sight, neighbour) for neighbour in sight.neighbours]))
        if sight.neighbours
        else 0.0
    )


def jensen_shannon(first: Sight, second: Sight) -> float:
    """Return H(w p + w' p') - w H(p) - w' H(p') in bits, w = a_t / (a_t + a_t'): 0 if alike, 1 if nothing is shared.

    It is also 1 if only one of the two sees nothing, and 0 if neither sees anything.
    """
    totals = [float(sight.weighted.sum()) for sight in (first, second)]
    total = sum(totals)
    if min(totals) == 0:
        return 0.0 if total == 0 else 1.0
    joint = np.zeros(first.subject.count)
    joint[first.surfaces] += first.weighted
    joint[second.surfaces] += second.weighted
    separate = sum(
        area * float(measures.entropy(sight.weighted)) for area, sight in zip(totals, (first, second), strict=True)
    )
    return max(float(measures.entropy(joint)) - separate / total, 0.0)


@measure("depth_stability", "most", "picture", "neighbours")
def depth_stability(sight: Sight) -> float:
    """Return the share of the views beside it whose depth images are like its own: their distance is below 0.87.

    The value is 0 if nothing is seen. It is coarse, as small images of one object often differ by about that distance.

    P. Vazquez, "Automatic view selection through depth-based view stability analysis", The Visual Computer 25, 2009,
    counts similar images among all views, which takes as many compressions as the square of the number of views.
    """
    if not sight.neighbours or sight.total == 0:
        return 0.0
    return float(np.mean([compression_distance(sight, neighbour) < SIMILAR for neighbour in sight.neighbours]))


def compression_distance(first: Sight, second: Sight) -> float:
    """Return the normalised distance (C(xy) - min(C(x), C(y))) / max(C(x), C(y)), C being the length after bzip2."""
    x, y = small_depth(first), small_depth(second)
    lengths = len(bz2.compress(x)), len(bz2.compress(y))
    return (len(bz2.compress(x + y)) - min(lengths)) / max(lengths)


def small_depth(sight: Sight) -> bytes:
    """Return the depth image in 64 x 64 bytes: 255 is nearest, 0 farthest or background."""
    assert sight.picture is not None
    depth: NDArray = np.where(sight.picture.hit, 1.0 - np.clip(sight.picture.depth, 0, 1), 0.0)
    rows, columns = (np.linspace(0, side - 1, SIDE).round().astype(int) for side in depth.shape)
    return (depth[np.ix_(rows, columns)] * 255).astype(np.uint8).tobytes()
