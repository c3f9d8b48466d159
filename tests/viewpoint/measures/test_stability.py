"""How much views differ."""

from types import SimpleNamespace

import numpy as np
import pytest

from tracer.viewpoint.measures import get, stability
from tracer.viewpoint.sight import Picture, Sight

SUBJECT = SimpleNamespace(count=4)


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
