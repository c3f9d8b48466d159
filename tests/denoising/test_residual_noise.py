"""The weight of the objective ``denoised``: what a denoiser leaves of the noise."""

import numpy as np
import pytest

import tracer
from tracer.denoising import residual_noise
from tracer.denoising.residual_noise import LEAST, ResidualNoise
from tracer.film.estimate import Statistics
from tracer.film.features import Features
from tracer.scene.view import open_scene


def statistics(mean):
    grid = mean.shape[:2]
    nothing = np.zeros((*grid, 0), np.float32)
    count = np.full(grid, 4, np.uint32)
    return Statistics(count, 0 * count, mean, mean, count.astype(np.float32), nothing, nothing)


def test_the_share_is_that_of_the_moves(cornell, monkeypatch):
    """A denoiser that leaves a tenth of the move on the left half, and all on the right."""
    random = np.random.default_rng(0)
    first, second = (random.random((48, 64, 3)).astype(np.float32) for _ in range(2))
    left = np.ones((48, 64, 1), np.float32)
    left[:, :32] = 0.1**0.5
    monkeypatch.setattr(residual_noise, "denoise", lambda image, albedo, normal: left * image)
    with open_scene(cornell(size=(64, 48))) as view:
        found = ResidualNoise(view, None, 0)
        found.features = Features(first, first, first[..., 0])
        found.update(statistics(first), statistics(second))
    share = found.share
    assert share[:, :20] == pytest.approx(np.full((48, 20), 0.1), rel=0.05)
    assert share[:, -20:] == pytest.approx(np.ones((48, 20)), rel=0.05)
    assert share.min() >= LEAST


def test_samples_go_where_the_denoiser_leaves_more(cornell):
    scene = cornell(size=(64, 48))
    plain = tracer.render(scene, spp=32, seed=1)
    aimed = tracer.render(scene, spp=32, seed=1, objective="denoised")
    assert aimed.samples.sum() == plain.samples.sum()
    assert not np.array_equal(aimed.samples, plain.samples)
    again = tracer.render(scene, spp=32, seed=1, objective="denoised")
    assert np.array_equal(aimed.samples, again.samples)
    assert aimed.report.seconds_denoising > 0
