"""How much views differ."""

import bz2
from types import SimpleNamespace

import numpy as np
import pytest

from tracer.viewpoint.measures import get, stability
from tracer.viewpoint.observation import Picture, Sight

SUBJECT = SimpleNamespace(count=4, weights=np.ones(4))


def sight(areas, neighbours=(), depth=None):
    areas = np.asarray(areas, float)
    picture = None if depth is None else Picture(np.isfinite(depth), depth.astype(np.float32))
    seen = np.flatnonzero(areas)
    return Sight(SUBJECT, seen, areas[seen], 10.0, picture=picture, neighbours=list(neighbours))


def test_divergence_is_0_for_like_views_and_1_for_those_that_share_nothing():
    one = sight([1, 2, 0, 0])
    assert stability.jensen_shannon(one, sight([2, 4, 0, 0])) == pytest.approx(0, abs=1e-12)
    assert stability.jensen_shannon(one, sight([0, 0, 1, 2])) == pytest.approx(1)
    assert stability.jensen_shannon(one, sight([0, 0, 0, 0])) == 1
    assert stability.jensen_shannon(sight([0, 0, 0, 0]), sight([0, 0, 0, 0])) == 0
    found = get("instability").value(sight([1, 2, 0, 0], [sight([1, 2, 0, 0]), sight([0, 0, 2, 1])]))
    assert found == pytest.approx(0.5)
    assert get("instability").value(one) == 0


def test_depth_images_that_are_alike_compress_together():
    generator = np.random.default_rng(1)
    noise, other = generator.random((2, 64, 64))
    first = sight([1, 0, 0, 0], depth=noise)
    assert stability.compression_distance(first, sight([1, 0, 0, 0], depth=noise)) < 0.87
    assert stability.compression_distance(first, sight([1, 0, 0, 0], depth=other)) > 0.87
    beside = [sight([1, 0, 0, 0], depth=depth) for depth in (noise, other)]
    assert get("depth_stability").value(sight([1, 0, 0, 0], beside, noise)) == 0.5


def stripes(rows):
    """Return a depth image of noise, the first ``rows`` of 64 alike in all, the others not."""
    same, own = np.random.default_rng(7).random((64, 64)), np.random.default_rng(rows).random((64, 64))
    return np.where(np.arange(64)[:, None] < rows, same, own)


def distance_by_hand(one, other):
    """Return the normalised compression distance of two depth images, nearer being brighter."""
    first, second = (((1 - np.float32(each)) * 255).astype(np.uint8).tobytes() for each in (one, other))
    sizes = [len(bz2.compress(data)) for data in (first, second, first + second)]
    return (sizes[2] - min(sizes[:2])) / max(sizes[:2])


def test_images_at_a_distance_below_087_are_alike():
    """The threshold of the paper (Vazquez, 2009), between pairs of images that lie on either side of it, close by."""
    image = stripes(64)
    others = {rows: stripes(rows) for rows in range(0, 64, 2)}
    distances = {rows: distance_by_hand(image, other) for rows, other in others.items()}
    below = [rows for rows in others if 0.8 < distances[rows] < 0.87]
    above = [rows for rows in others if 0.87 <= distances[rows] < 0.94]
    assert below
    assert above
    for rows, alike in [*((rows, 1) for rows in below), *((rows, 0) for rows in above)]:
        beside = [sight([1, 0, 0, 0], depth=others[rows])]
        assert get("depth_stability").value(sight([1, 0, 0, 0], beside, image)) == alike
