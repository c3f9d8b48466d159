"""Entropies and divergences of a pixel's samples: analysis, and brute force over all samples."""

import numpy as np
import pytest

from tracer import criteria
from tracer.complexity import measures
from tracer.criteria import generalised_entropies
from tracer.image.colour import LUMINANCE

from .made_up import evidence_of, importance, light, statistics_of

BRUTE_FORCE = {
    "kullback_leibler": measures.kullback_leibler,
    "chi_square": measures.chi_square,
    "hellinger": measures.hellinger,
}


def lack_of_tsallis(values):
    index = generalised_entropies.INDEX
    return 1 - measures.tsallis(values, index) / measures.tsallis(np.ones(values.shape[-1]), index)


def lack_of_renyi(values):
    return 1 - measures.renyi(values, generalised_entropies.INDEX) / np.log2(values.shape[-1])


CONTRASTS = {"colour_contrast": measures.contrast, "tsallis": lack_of_tsallis, "renyi": lack_of_renyi}


def some_white(equal, number):
    """Return samples of one pixel, (N, 1, 1, 3): ``equal`` of them white, the rest black."""
    samples = np.zeros((number, 1, 1, 3))
    samples[:equal] = 1
    return samples


ANALYSIS = {
    "kullback_leibler": lambda ratio: np.log(ratio),
    "chi_square": lambda ratio: ratio - 1,
    "hellinger": lambda ratio: 1 - np.sqrt(1 / ratio),
}


@pytest.mark.parametrize(("equal", "number"), [(1, 2), (1, 16), (8, 16), (3, 24)])
@pytest.mark.parametrize("name", ANALYSIS)
def test_k_equal_samples_among_n(name, equal, number):
    expected = ANALYSIS[name](number / equal)
    mean = equal / number
    assert importance(name, some_white(equal, number)) == pytest.approx(mean * expected / number, rel=1e-5)
    root = importance(f"root_{name}", some_white(equal, number))
    assert root == pytest.approx(mean * np.sqrt(expected) / number, rel=1e-5)


@pytest.mark.parametrize("number", [2, 8, 64])
def test_contrast_of_half_black_half_white_depends_on_n(number):
    samples = some_white(number // 2, number)
    assert importance("colour_contrast", samples) == pytest.approx(0.5 / np.log2(number), rel=1e-5)
    assert importance("renyi", samples) == pytest.approx(0.5 / np.log2(number), rel=1e-5)
    # with q = 2 it is chi^2 / (N - 1)
    assert importance("tsallis", samples) == pytest.approx(0.5 / (number - 1), rel=1e-5)


@pytest.mark.parametrize("name", [*BRUTE_FORCE, *CONTRASTS])
def test_sums_tell_what_all_samples_would(name):
    samples = light().astype(np.float32).astype(np.float64)
    of_channels = {**BRUTE_FORCE, **CONTRASTS}[name](np.moveaxis(samples, 0, -1))
    mean = samples.mean(axis=0)
    per_sample = 1 / len(samples) if name in BRUTE_FORCE else 1
    expected = (of_channels * mean * LUMINANCE).sum(axis=-1) * per_sample
    assert importance(name, samples) == pytest.approx(expected, rel=1e-4, abs=1e-7)
    if name in BRUTE_FORCE:
        expected = (np.sqrt(of_channels) * mean * LUMINANCE).sum(axis=-1) * per_sample
        assert importance(f"root_{name}", samples) == pytest.approx(expected, rel=1e-4, abs=1e-7)


def test_entropies_of_another_index(monkeypatch):
    monkeypatch.setattr(generalised_entropies, "INDEX", 1.5)
    for name in ("tsallis", "renyi"):
        test_sums_tell_what_all_samples_would(name)


@pytest.mark.parametrize("level", [1e-4, 0.1, 17.3, 1234.567])
@pytest.mark.parametrize("name", [*(f"root_{each}" for each in BRUTE_FORCE), *CONTRASTS])
def test_pixels_without_noise_have_none_by_rounding(name, level):
    assert np.all(importance(name, np.full((300, 1, 1, 3), level)) == 0)


@pytest.mark.parametrize("name", ["kullback_leibler", "root_hellinger", "tsallis", "rigau"])
def test_dimmed_pictures_ask_for_the_same(name):
    samples = light()
    bright, dim = (found(name, factor * samples) for factor in (1.0, 0.01))
    assert dim / dim.max() == pytest.approx(bright / bright.max(), rel=1e-3)


def found(name, samples):
    """Return an importance where pilot rays have seen no edges."""
    return importance(name, samples, look=lambda: Seen(np.zeros(samples.shape[1:3])))


class Seen:
    """What pilot rays have seen."""

    def __init__(self, geometry_contrast):
        self.geometry_contrast = geometry_contrast


def test_rigau_weighs_contrasts_by_the_share_of_the_pixel():
    samples = light()
    of_colour = importance("colour_contrast", samples)
    brightness = samples.mean(axis=0) @ LUMINANCE
    edges = np.random.default_rng(1).random(brightness.shape)
    expected = (0.5 * of_colour + 0.5 * brightness * edges) / brightness.mean()
    assert importance("rigau", samples, look=lambda: Seen(edges)) == pytest.approx(expected, rel=1e-4)


def test_one_channel_is_a_grey_film():
    grey = light(channels=1)
    for name in ("kullback_leibler", "root_chi_square", "colour_contrast", "renyi", "contrast", "cycles", "z_test"):
        expected = importance(name, grey.repeat(3, axis=-1))
        assert importance(name, grey, channels=1) == pytest.approx(expected, rel=1e-4, abs=1e-7), name


def test_one_sample_has_no_divergence_and_comes_first():
    known = statistics_of(light(number=8), "kullback_leibler")
    known.count[0, 0] = 1
    evidence = evidence_of(known)
    values = criteria.get("kullback_leibler").importance(evidence)
    assert values[0, 0] == values.ravel()[1:].max()
