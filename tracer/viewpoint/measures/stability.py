"""How much a view differs from those beside it."""

from __future__ import annotations

import bz2

import numpy as np
from numpy.typing import NDArray

from tracer.complexity import measures
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.observation import Sight

SIMILAR = 0.87
"""Depth images that compress together to less are alike."""
SIDE = 64
"""Depth images are made this small before."""


@measure("instability", "least", "neighbours")
def instability(sight: Sight) -> float:
    """Return the mean Jensen-Shannon divergence in bits between this view and those beside it, weighted by area.

    M. Feixas, M. Sbert and F. Gonzalez, 2009, section 4.2. 0 without neighbours; 1, the worst, if nothing is seen.
    """
    if sight.total == 0:
        return 1.0
    return float(np.mean([jensen_shannon(sight, other) for other in sight.neighbours])) if sight.neighbours else 0.0


def jensen_shannon(one: Sight, other: Sight) -> float:
    """Return H(w p + w' p') - w H(p) - w' H(p') in bits, w = a_t / (a_t + a_t'): 0 if alike, 1 if nothing is shared.

    1 too where one of them sees nothing and the other does.
    """
    total = one.total + other.total
    if one.total == 0 or other.total == 0:
        return 0.0 if total == 0 else 1.0
    both = np.zeros(one.subject.count)
    both[one.surfaces] += one.projected
    both[other.surfaces] += other.projected
    own = sum(each.total * float(measures.entropy(each.projected)) for each in (one, other))
    return max(float(measures.entropy(both)) - own / total, 0.0)


@measure("depth_stability", "most", "picture", "neighbours")
def depth_stability(sight: Sight) -> float:
    """Return the share of the views beside it whose depth image is alike: normalised compression distance below 0.87.

    0 if nothing is seen. Small images of one object often differ by about as much, so it is coarse.

    P. Vazquez, "Automatic view selection through depth-based view stability analysis", The Visual Computer 25, 2009,
    counts them among all views, which takes the square of their number of compressions.
    """
    if not sight.neighbours or sight.total == 0:
        return 0.0
    return float(np.mean([compression_distance(sight, other) < SIMILAR for other in sight.neighbours]))


def compression_distance(one: Sight, other: Sight) -> float:
    """Return (C(xy) - min(C(x), C(y))) / max(C(x), C(y)) with C the length after bzip2."""
    x, y = small_depth(one), small_depth(other)
    apart = len(bz2.compress(x)), len(bz2.compress(y))
    return (len(bz2.compress(x + y)) - min(apart)) / max(apart)


def small_depth(sight: Sight) -> bytes:
    """Return the depth image in 64 x 64 bytes."""
    assert sight.picture is not None
    depth: NDArray = np.where(sight.picture.hit, 1.0 - np.clip(sight.picture.depth, 0, 1), 0.0)
    rows, columns = (np.linspace(0, side - 1, SIDE).round().astype(int) for side in depth.shape)
    return (depth[np.ix_(rows, columns)] * 255).astype(np.uint8).tobytes()
