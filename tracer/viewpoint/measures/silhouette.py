"""Measures of the silhouette: the outlines of what is seen, holes included, as chains of steps between pixels.

Steps go through the middles of pixel edges and turn by multiples of 45 degrees.
"""

from __future__ import annotations

import numpy as np

from tracer.complexity import measures
from tracer.core.arrays import Floats
from tracer.viewpoint.measures.registry import measure
from tracer.viewpoint.observation import Sight


def outlines(sight: Sight) -> list[Floats]:
    """Return the steps (N, 2) of every closed outline, in pixels."""
    from skimage.measure import find_contours

    assert sight.picture is not None
    mask = np.pad(sight.picture.hit, 1).astype(np.float32)
    return [np.diff(contour, axis=0) for contour in find_contours(mask, 0.5)]


def turns(sight: Sight) -> Floats:
    """Return the angle (N,) in radians, -pi to pi, between every step of an outline and the next step."""
    angles = [np.zeros(0)]
    for steps in outlines(sight):
        heading = np.arctan2(steps[:, 0], steps[:, 1])
        turn = np.diff(heading, append=heading[:1])
        angles.append((turn + np.pi) % (2 * np.pi) - np.pi)
    return np.concatenate(angles)


@measure("silhouette_length", "most", "picture")
def silhouette_length(sight: Sight) -> float:
    """Return the length of all outlines as a multiple of the image's side."""
    assert sight.picture is not None
    length = sum(float(np.linalg.norm(steps, axis=1).sum()) for steps in outlines(sight))
    return length / sight.picture.hit.shape[0]


@measure("silhouette_entropy", "most", "picture")
def silhouette_entropy(sight: Sight) -> float:
    """Return the entropy in bits of the turns in 8 classes, multiples of 45 degrees."""
    angles = turns(sight)
    return float(measures.entropy(np.bincount(np.rint(angles / (np.pi / 4)).astype(int) % 8, minlength=8)))


@measure("silhouette_curvature", "most", "picture")
def silhouette_curvature(sight: Sight) -> float:
    """Return the mean size of the turns in right angles; 0 if nothing is seen."""
    angles = turns(sight)
    return float(np.mean(np.abs(angles) / (np.pi / 2))) if len(angles) else 0.0


@measure("silhouette_curvature_extrema", "most", "picture")
def silhouette_curvature_extrema(sight: Sight) -> float:
    """Return the mean square of the turns in right angles; 0 if nothing is seen."""
    angles = turns(sight)
    return float(np.mean((angles / (np.pi / 2)) ** 2)) if len(angles) else 0.0
