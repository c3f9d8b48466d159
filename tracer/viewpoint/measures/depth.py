"""Measures of depth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tracer.viewpoint.measures.areas import projected_area
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.observation import Sight

BINS = 256
"""There are this many classes of depth from 0 to 1."""


def depths(sight: Sight) -> NDArray[np.float32]:
    """Return the depth (N,), 0 to 1, of the N pixels that see a surface."""
    assert sight.picture is not None
    return np.clip(sight.picture.depth[sight.picture.hit], 0.0, 1.0)


@measure("maximum_depth", "most", "picture")
def maximum_depth(sight: Sight) -> float:
    """Return the largest depth that is seen; 0 if nothing is seen."""
    return float(depths(sight).max(initial=0.0))


@measure("depth_distribution", "most", "picture")
def depth_distribution(sight: Sight) -> float:
    """Return 1 - sum h^2 of the shares h of 256 classes of depth: high if all depths are seen; 0 if nothing is seen."""
    counts = np.histogram(depths(sight), BINS, (0.0, 1.0))[0]
    return float(1.0 - np.sum((counts / counts.sum()) ** 2)) if counts.any() else 0.0


@measure("stoev_strasser", "most", "picture")
def stoev_strasser(sight: Sight) -> float:
    """Return (p + d + 1 - |d - p|) / 3 of projected area p and maximum depth d: high if both are large and about equal.

    S. Stoev and W. Strasser, "A case study on automatic camera placement and motion for visualizing historical data",
    IEEE Visualization 2002. The value is 0 if nothing is seen.
    """
    if not len(sight.surfaces):
        return 0.0
    p, d = projected_area(sight), maximum_depth(sight)
    return (p + d + 1.0 - abs(d - p)) / 3.0
