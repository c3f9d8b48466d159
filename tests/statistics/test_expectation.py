"""The mean over seeds of adaptive renders agrees with ``mi.render`` (Z-test, Šidák), and does not where it must not."""

import mitsuba as mi
import numpy as np
import pytest
from scipy import stats

import tracer
from conformance.cases import FILTERS, mitsuba_picture, name, scene
from tracer.film.estimate import Estimate
from tracer.sampling import samples
from tracer.sampling.wavefront import lane_pixels, line_of
from tracer.scene.view import open_scene

SEEDS = 32
REFERENCES = 16
FALSE_ALARM = 0.001
"""Probability that a correct estimate fails a test, over all pixels and channels (Šidák)."""
CASES = [
    *({"filter_name": each} for each in FILTERS),
    *({"integrator": each} for each in ("path", "volpath", "volpathmis", "prb", "depth", "moment", "aov")),
    *({"sensor": each} for each in ("thinlens", "orthographic", "shutter")),
    *({"film": each} for each in ("rgba", "luminance", "crop_and_border", "float16")),
]


def reference(description):
    """Return mean and standard error of many pictures by ``mi.render``."""
    loaded = mi.load_dict(description)
    pictures = np.stack([np.array(mitsuba_picture(loaded, 10**6 + k, 1024)) for k in range(REFERENCES)])
    return pictures.mean(axis=0, dtype=np.float64), pictures.std(axis=0, ddof=1) / np.sqrt(REFERENCES)


def z_scores(images, truth, error_of_truth):
    """Return (mean over seeds - reference) / standard error, for every value of the image."""
    images = np.asarray(images, np.float64)
    error = images.std(axis=0, ddof=1) / np.sqrt(len(images))
    # A floor stands for float32 where a pixel has no noise at all.
    error = np.sqrt(error**2 + error_of_truth**2) + 1e-5 * np.maximum(1, np.abs(truth))
    return (images.mean(axis=0) - truth) / error


def limit(scores):
    """Return what the largest of so many |scores| exceeds with probability FALSE_ALARM if there is no bias."""
    per_value = 1 - (1 - FALSE_ALARM) ** (1 / scores.size)
    return stats.t.ppf(1 - per_value / 2, SEEDS - 1)


def render_seeds(description, **settings):
    loaded = mi.load_dict(description)
    return [tracer.render(loaded, seed=seed, **settings).image for seed in range(SEEDS)]


@pytest.mark.parametrize("filter_name", ["box", "gaussian"])
def test_mean_over_seeds_agrees_with_mitsuba(filter_name):
    description = scene(filter_name=filter_name)
    scores = z_scores(render_seeds(description, spp=64), *reference(description))
    assert np.abs(scores).max() < limit(scores)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=name)
def test_mean_over_seeds_agrees_for(case):
    description = scene(**case)
    scores = z_scores(render_seeds(description, spp=64), *reference(description))
    assert np.abs(scores).max() < limit(scores)


@pytest.mark.slow
def test_a_picture_two_percent_too_bright_does_not_pass():
    brighter = scene()
    brighter["lamp"]["emitter"]["radiance"] *= 1.02
    scores = z_scores(render_seeds(brighter, spp=64), *reference(scene()))
    assert np.abs(scores).max() > limit(scores)


@pytest.mark.slow
@pytest.mark.parametrize("filter_name", FILTERS)
def test_a_step_of_counts_leaves_no_trace(filter_name):
    """4 samples a pixel left of an edge of the picture, 1024 right of it."""
    description = scene(filter_name=filter_name)
    images = []
    with open_scene(description) as view:
        sampler = mi.load_dict({"type": "owen_sobol"})
        recorded = samples.Recorded(view, sampler)
        counts = np.full(view.grid, 4, np.uint32)
        counts[:, view.grid[1] // 2 :] = 1024
        for seed in range(SEEDS):
            estimate = Estimate(view)
            for window in line_of(counts.ravel()).passes(1 << 20):
                pixel, index = lane_pixels(window)
                estimate.add(window, recorded(mi.UInt32(seed), pixel, index, mi.Float(1 / 8)))
            images.append(estimate.develop()[0])
        recorded.close()
    scores = z_scores(images, *reference(description))
    assert np.abs(scores).max() < limit(scores)
