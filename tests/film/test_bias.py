"""Samples that decide lose light; how much is measured without bias, and given back where the picture is noisy."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import tracer
from tracer.core.device import upload
from tracer.film import bias
from tracer.film.bias import UnbiasedMean, chances, light_added, lost_light, trusted, weights
from tracer.film.estimate import Statistics
from tracer.session.merge import merge

SIZE, PICTURES = (40, 40), 60
LIMIT = stats.norm.ppf(1 - 1e-4 / 2)
"""|z| that an unbiased mean exceeds once in ten thousand times."""


def known(samples, count):
    """Return the statistics of the first ``count`` (H, W) of samples (H, W, N), of one channel."""
    taken = np.arange(samples.shape[-1]) < count[..., None]
    mean = ((samples * taken).sum(axis=-1) / count)[..., None].astype(np.float32)
    nothing = np.zeros((*count.shape, 0), np.float32)
    zeros = np.zeros(count.shape, np.uint32)
    return Statistics(count.astype(np.uint32), zeros, mean, np.zeros_like(mean), mean[..., 0], nothing, nothing)


def greedy(statistics, generator, by_chance):
    """Return counts that follow each pixel's own mean, and the chance of a sample; dark ones get it by chance alone."""
    mean = statistics.mean[..., 0]
    more = np.select([mean > 1.5, mean > 0.7], [12, 4], 0)
    chance = np.full(mean.shape, 0.25) if by_chance else np.zeros(mean.shape)
    picked = (generator.random(mean.shape) < chance) & (more == 0)
    return statistics.count + more + picked, np.where(more > 0, 1, chance).astype(np.float32)


@pytest.mark.parametrize("rounds", [2, 3])
def test_the_mean_over_rounds_has_no_bias_where_the_plain_mean_has_one(rounds):
    """Samples of a skewed distribution of mean 1, independent of each other, and counts that follow what was bright."""
    generator = np.random.default_rng(5)
    plain, unbiased = [], []
    for _ in range(PICTURES):
        samples = generator.exponential(size=(*SIZE, 64))
        before, statistics = None, known(samples, np.full(SIZE, 4))
        mean = UnbiasedMean.nothing(SIZE, 1)
        for number in range(1, rounds):
            mean = mean.after(before, statistics)
            count, chance = greedy(statistics, generator, by_chance=number == rounds - 1)
            before, statistics = statistics, known(samples, count)
        mean = mean.closed(before, statistics, chance)
        plain.append(statistics.mean.mean())
        unbiased.append(mean.above(statistics).mean() + statistics.mean.mean())
    assert z_of(plain) < -10 * LIMIT
    assert abs(z_of(unbiased)) < LIMIT


def z_of(means):
    return (np.mean(means) - 1) / (np.std(means, ddof=1) / np.sqrt(len(means)))


def test_a_stopped_render_counts_what_waits_by_what_there_is():
    generator = np.random.default_rng(1)
    samples = generator.exponential(size=(*SIZE, 64))
    first = known(samples, np.full(SIZE, 4))
    second = known(samples, greedy(first, generator, by_chance=False)[0])
    mean = UnbiasedMean.nothing(SIZE, 1).after(None, first).after(first, second)
    waits = second.count == 4
    assert np.all(mean.waiting[waits] > 0)
    stopped = mean.given_up(second)
    assert not stopped.waiting.any()
    expected = np.where(waits[..., None], first.mean, mean.total / mean.weight[..., None])
    assert np.allclose(stopped.total / stopped.weight[..., None], expected, rtol=1e-5)


def test_means_of_a_round_by_hand():
    samples = np.arange(16.0).reshape(1, 2, 8)
    before, after = known(samples, np.array([[2, 4]])), known(samples, np.array([[6, 4]]))
    mean = UnbiasedMean.nothing((1, 2), 1).closed(before, after, None)
    own = mean.total[..., 0] / mean.weight
    assert own[0, 0] == pytest.approx(samples[0, 0, 2:6].mean())
    assert own[0, 1] == pytest.approx(samples[0, 1, :4].mean())  # without samples in the round: what was known before


def test_a_round_is_weighed_by_pixels_around_that_are_not_next():
    drawn = np.zeros((40, 40), np.float32)
    drawn[20, 20] = 9.0
    found = weights(upload(mi.Float, drawn), drawn.shape).numpy().reshape(drawn.shape) - 1e-3 * drawn.mean()
    for row, column in ((20, 20), (18, 22), (26, 14), (23, 20), (27, 20)):
        far = max(abs(row - 20), abs(column - 20))
        assert found[row, column] == pytest.approx(9 / (169 - 25) if 2 < far <= 6 else 0, abs=1e-6)


def test_equal_counts_lose_nothing():
    samples = np.random.default_rng(2).random((*SIZE, 8))
    first, second = (known(samples, np.full(SIZE, count)) for count in (4, 8))
    mean = UnbiasedMean.nothing(SIZE, 1).after(None, first).closed(first, second, None)
    assert not mean.above(second).any()
    assert np.allclose(mean.total / mean.weight[..., None], second.mean, rtol=1e-5)


@given(st.floats(-0.5, 0.5), st.integers(0, 2**32 - 1))
def test_all_of_it_is_given_back_but_no_more_than_a_twentieth(part, seed):
    generator = np.random.default_rng(seed)
    image = generator.random((6, 5, 4)).astype(np.float32) + 0.5
    stderr = generator.random((6, 5, 4)).astype(np.float32) * 0.2
    missing = (generator.normal(size=(6, 5, 4)) * 0.1 + part * image).astype(np.float32)
    lost = lost_light(image, stderr, missing, colours=3)
    assert not lost[..., 3].any()
    assert np.all(np.abs(lost) <= bias.MOST * image * 1.0001)
    for channel in range(3):
        wanted, given_back = missing[..., channel].sum(dtype=np.float64), lost[..., channel].sum(dtype=np.float64)
        wanted *= trusted(upload(mi.Float64, missing[..., :3].sum(axis=-1, dtype=np.float64)))
        noise, brightness = bias.NOISY * stderr[..., channel], image[..., channel]
        most = bias.MOST * (noise * brightness / (noise + brightness)).sum()
        assert given_back == pytest.approx(np.clip(wanted, -most, most), rel=1e-3, abs=1e-4)
    assert light_added(image + lost, image, 3) == pytest.approx(lost[..., :3].mean() / image[..., :3].mean(), abs=1e-6)


def test_what_is_measured_is_trusted_as_far_as_its_error_allows():
    """Of normal numbers around a mean of as many standard errors, the factor is near that of least squared error."""
    generator = np.random.default_rng(3)
    for errors in (0.0, 1.0, 3.0, 10.0):
        numbers = generator.normal(errors / 100, 1.0, (200, 100, 100))  # of 10^4, the mean has an error of 1 / 100
        factors = np.array([trusted(upload(mi.Float64, picture)) for picture in numbers])
        means = numbers.mean(axis=(1, 2)) * 100
        assert factors == pytest.approx(means**2 / (means**2 + 1), rel=0.05, abs=0.01)
        if errors == 0:
            assert np.mean((factors * means) ** 2) < 0.6 * np.mean(means**2)
        if errors == 10:
            assert factors.min() > 0.97
    assert trusted(dr.zeros(mi.Float64, 4)) == 0
    assert trusted(dr.full(mi.Float64, np.inf, 4)) == 0


def test_what_has_no_noise_stays_as_it_is():
    image = np.ones((4, 4, 3), np.float32)
    stderr = np.zeros_like(image)
    stderr[:2] = 0.1
    lost = lost_light(image, stderr, np.full_like(image, 0.01), colours=3)
    assert lost[:2].min() > 0
    assert not lost[2:].any()
    assert not lost_light(image, 0 * stderr, np.full_like(image, 0.01), colours=3).any()
    assert not lost_light(image, stderr, np.full_like(image, np.inf), colours=3).any()


def test_every_pixel_has_a_chance_in_proportion_to_its_importance():
    assert chances(mi.Float64([0.0, 1.0, 3.0, 4.0])).numpy().tolist() == [1 / 16, 0.25, 0.75, 1.0]
    assert np.all(chances(dr.zeros(mi.Float64, 4)).numpy() == 0.5)


BRIGHT = {"spp": 16, "seed": 3}


def test_the_default_gives_back_what_other_ways_do_not_lose(cornell):
    scene = cornell(size=(48, 32))
    assert tracer.render(scene, **BRIGHT).report.light_given_back != 0
    for settings in ({"criterion": "uniform"}, {"spp": 64, "unbiased": True}, {"criterion": "shape_entropy"}):
        assert tracer.render(scene, **BRIGHT | settings).report.light_given_back == 0


def test_a_merge_gives_back_what_its_parts_have_lost(cornell, tmp_path):
    scene, paths = cornell(size=(48, 32)), [tmp_path / f"{seed}.ckpt" for seed in (1, 2, 3)]
    parts = [tracer.render(scene, spp=16, seed=seed, checkpoint=path) for seed, path in enumerate(paths)]
    alone, _ = merge(paths[:1])
    assert np.array_equal(alone.image, parts[0].image)
    whole, _ = merge(paths)
    merge(paths[:2], tmp_path / "two.ckpt")
    nested, _ = merge([tmp_path / "two.ckpt", paths[2]])
    assert whole.report.light_given_back == pytest.approx(nested.report.light_given_back, rel=1e-4)
    assert 0 < abs(whole.report.light_given_back) < max(abs(part.report.light_given_back) for part in parts)


def test_a_part_that_was_stopped_before_it_decided_does_not_end_the_correction(cornell, tmp_path):
    scene, paths = cornell(size=(48, 32)), [tmp_path / "whole.ckpt", tmp_path / "stopped.ckpt"]
    whole = tracer.render(scene, spp=16, seed=3, checkpoint=paths[0])
    tracer.render(scene, spp=16, seed=23, checkpoint=paths[1], progress=lambda now: False)
    found, _ = merge(paths)
    assert 0.2 < found.report.light_given_back / whole.report.light_given_back < 2


def test_a_denoised_picture_gets_light_by_its_own_brightness():
    image, clean = np.full((8, 8, 3), 0.05, np.float32), np.full((8, 8, 3), 0.05, np.float32)
    image[4, 4] = 50.0
    stderr = np.maximum(image, 0.01)
    missing = np.full_like(image, 0.01)
    assert lost_light(image, stderr, missing, 3)[4, 4].min() > 0.1
    assert lost_light(clean, stderr, missing, 3).max() <= bias.MOST * 0.05 * 1.0001
