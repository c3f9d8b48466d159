"""The exact smallest view set, against brute force."""

import itertools

import numpy as np
import pytest

from benchmarks.viewpoint.minimum_cover import fewest_views


@pytest.mark.parametrize("enough", [1.0, 0.8])
@pytest.mark.parametrize("seed", range(5))
def test_no_smaller_set_exists(seed, enough):
    generator = np.random.default_rng(seed)
    shown, weights = generator.random((9, 30)) < 0.3, generator.random(30)
    weights[~shown.any(axis=0)] = 0

    def covers(views):
        return weights[shown[list(views)].any(axis=0)].sum() >= enough * weights.sum() - 1e-9

    found = fewest_views(shown, weights, enough)
    assert covers(found.chosen)
    assert found.least == len(found.chosen)
    smaller = itertools.combinations(range(9), len(found.chosen) - 1)
    assert not any(covers(views) for views in smaller)


def test_nothing_to_show():
    found = fewest_views(np.zeros((4, 3), bool), np.ones(3))
    assert len(found.chosen) == 0
    assert found.least == 0
