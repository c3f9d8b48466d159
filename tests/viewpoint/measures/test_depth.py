"""Depth of pictures made by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from tracer.viewpoint.measures import get
from tracer.viewpoint.observation import Picture, Sight


def sight(depth, share=0.5):
    depth = np.asarray(depth, np.float32)
    hit = np.isfinite(depth)
    surfaces = np.array([0]) if hit.any() else np.array([], int)
    subject = SimpleNamespace(weights=np.ones(1))
    return Sight(subject, surfaces, np.full(len(surfaces), share), 1.0, picture=Picture(hit, depth))


def test_depth_of_what_is_seen():
    seen = sight([[0.1, np.nan], [0.7, 0.3]])
    assert get("maximum_depth").value(seen) == pytest.approx(0.7)
    assert get("depth_distribution").value(seen) == pytest.approx(1 - 3 / 9)
    assert get("depth_distribution").value(sight([[0.5, 0.5]])) == 0
    even = sight((np.arange(256) + 0.5)[None] / 256)
    assert get("depth_distribution").value(even) == pytest.approx(1 - 1 / 256)


@pytest.mark.parametrize(("share", "depth"), [(0.5, 0.5), (0.2, 0.9), (1.0, 1.0)])
def test_stoev_and_strasser_want_both(share, depth):
    found = get("stoev_strasser").value(sight([[depth, np.nan]], share))
    assert found == pytest.approx((share + depth + 1 - abs(depth - share)) / 3, abs=1e-6)


def test_nothing_has_no_depth():
    nothing = sight([[np.nan, np.nan]])
    assert [get(name).value(nothing) for name in ("maximum_depth", "depth_distribution", "stoev_strasser")] == [0, 0, 0]
