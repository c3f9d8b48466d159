"""The mean over seeds of adaptive renders agrees with the reference."""

import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

import tracer

SEEDS = 32
FALSE_ALARM = 0.001
"""Probability that a correct estimate fails a test, over all pixels and channels (Šidák)."""


def lit_scene(filter_name):
    """A ball and a block under a small lamp: edges, shadows, and no light that is found only by chance."""
    t = mi.ScalarTransform4f()
    lamp = {"type": "rectangle", "to_world": t.look_at([1, 3, 2], [0, 0, 0], [0, 0, 1]) @ t.scale(0.8)}
    film = {"type": "hdrfilm", "width": 20, "height": 16, "rfilter": {"type": filter_name}}
    return {
        "type": "scene",
        "integrator": {"type": "direct"},
        "sensor": {"type": "perspective", "to_world": t.look_at([0, 1.5, 5], [0, 0, 0], [0, 1, 0]), "film": film},
        "lamp": lamp | {"emitter": {"type": "area", "radiance": 6.0}},
        "ball": {"type": "sphere", "center": [-0.6, 0, 0], "radius": 0.7},
        "block": {"type": "cube", "to_world": t.translate([0.9, -0.3, 0]) @ t.scale(0.4)},
        "floor": {"type": "rectangle", "to_world": t.translate([0, -0.7, 0]) @ t.rotate([1, 0, 0], -90) @ t.scale(4)},
    }


def z_scores(scene, truth, **settings):
    """Return (mean over seeds of scene - reference of truth) / standard error, for every value of the image."""
    scene = mi.load_dict(scene)
    images = np.stack([tracer.render(scene, seed=seed, **settings).image for seed in range(SEEDS)]).astype(np.float64)
    reference = tracer.render(truth, seed=10**6, spp=4096, criterion="uniform")
    # The reference has an error of its own; a floor stands for float32 where a pixel has no noise at all.
    error = images.std(axis=0, ddof=1) / np.sqrt(SEEDS)
    error = np.sqrt(error**2 + reference.stderr.astype(np.float64) ** 2) + 1e-5
    return (images.mean(axis=0) - reference.image) / error


def limit(scores):
    """Return what the largest of so many |scores| exceeds with probability FALSE_ALARM if there is no bias."""
    per_value = 1 - (1 - FALSE_ALARM) ** (1 / scores.size)
    return stats.t.ppf(1 - per_value / 2, SEEDS - 1)


@pytest.mark.parametrize("filter_name", ["box", "tent", "gaussian"])
def test_mean_over_seeds_agrees_with_the_reference(filter_name):
    scores = z_scores(lit_scene(filter_name), lit_scene(filter_name), spp=64, criterion="fused")
    assert np.abs(scores).max() < limit(scores)


def test_a_picture_two_percent_too_bright_does_not_pass():
    brighter = lit_scene("gaussian")
    brighter["lamp"]["emitter"]["radiance"] *= 1.02
    scores = z_scores(brighter, lit_scene("gaussian"), spp=64, criterion="fused")
    assert np.abs(scores).max() > limit(scores)
