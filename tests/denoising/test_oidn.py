"""Denoising: what is flat stays flat to its edge, what is noisy comes nearer to its reference, and errors say what."""

import builtins
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import mitsuba as mi
import numpy as np
import pytest

import tracer
from conftest import small_scene
from tracer.denoising.oidn import denoise
from tracer.errors import DenoiseError, TracerError
from tracer.film.features import draw_features
from tracer.image import metrics
from tracer.scene.view import open_scene


@pytest.mark.parametrize("size", [(1, 1), (1, 200), (3, 2), (40, 30), (100, 120)])
@pytest.mark.parametrize("value", [0.001, 0.5, 3e4])
@pytest.mark.parametrize("albedo", [None, 0.0, 0.7])
def test_a_constant_stays_constant_to_its_edge(size, value, albedo):
    image = np.full((*size, 3), value)
    found = denoise(image) if albedo is None else denoise(image, np.full_like(image, albedo), 0 * image)
    assert found.shape == image.shape
    assert found.dtype == np.float32
    assert found == pytest.approx(image, rel=0.01)


def test_black_stays_black():
    assert np.abs(denoise(np.zeros((20, 20, 3)))).max() < 1e-5


@pytest.fixture(scope="module")
def small():
    """Return picture with 8 spp, features and reference of a small scene, each pixel by itself."""
    with open_scene(small_scene((96, 96), "box")) as view:
        noisy, reference = pictures(view.scene)
        counts = np.full(view.grid, 8, np.uint32)
        features = draw_features(view, mi.load_dict({"type": "owen_sobol"}), 1, counts, filtered=False)
    return noisy, features, reference


def pictures(scene):
    """Return a noisy picture and its reference."""
    return [
        tracer.render(scene, spp=spp, criterion="uniform", seed=seed).image[..., :3]
        for spp, seed in ((8, 1), (1024, 2))
    ]


def test_noise_falls(small):
    noisy, features, reference = small
    colour_only, guided = denoise(noisy), denoise(noisy, features.albedo, features.normal)
    before = metrics.relative_mse(noisy, reference)
    assert metrics.relative_mse(colour_only, reference) < before / 5
    assert metrics.relative_mse(guided, reference) < before / 5
    # Squared errors are mostly those of a few pixels at the edge of the lamp; what is seen gets better with features.
    assert metrics.flip(guided, reference) < metrics.flip(colour_only, reference)
    assert metrics.flip(colour_only, reference) < 0.7 * metrics.flip(noisy, reference)


@pytest.mark.slow
def test_noise_of_shared_samples_stays(small):
    """Why pixels must be means of their own samples; should this fail, the denoiser has learned of filters."""
    noisy, reference = pictures(small_scene((96, 96), "gaussian"))
    features = small[1]
    after = metrics.relative_mse(denoise(noisy, features.albedo, features.normal), reference)
    assert after > metrics.relative_mse(noisy, reference) / 3


def test_energy_is_kept(small):
    noisy, features, _ = small
    found = denoise(noisy, features.albedo, features.normal)
    assert found.mean(axis=(0, 1)) == pytest.approx(noisy.mean(axis=(0, 1)), rel=0.02)
    assert found.min() >= 0


def test_twice_is_the_same_and_inputs_are_left_alone(small):
    noisy, features, _ = small
    copies = [each.copy() for each in (noisy, features.albedo, features.normal)]
    first, second = (denoise(noisy, features.albedo, features.normal) for _ in range(2))
    assert np.array_equal(first, second)
    for each, copy in zip((noisy, features.albedo, features.normal), copies, strict=True):
        assert np.array_equal(each, copy)


@pytest.mark.slow
def test_tiles_change_nothing(small, monkeypatch):
    image = np.tile(small[0], (8, 8, 1))
    whole = denoise(image)
    monkeypatch.setattr("tracer.denoising.oidn.MOST_MEMORY", 100)
    assert np.array_equal(denoise(image), whole)


def test_values_that_are_not_finite_count_as_zero(small):
    noisy, features, _ = small
    clean = noisy.copy()
    clean[10:12, 20] = 0
    broken = clean.copy()
    broken[10, 20], broken[11, 20, 1] = np.nan, np.inf
    for extra in ((), (features.albedo, features.normal)):
        assert np.array_equal(denoise(broken, *extra), denoise(clean, *extra))
    holes = features.normal.copy()
    holes[5, 5] = np.nan
    assert np.all(np.isfinite(denoise(noisy, features.albedo, holes)))


def test_other_number_types_and_layouts(small):
    noisy = small[0]
    expected = denoise(noisy)
    for same in (noisy.astype(np.float64), np.asfortranarray(noisy), noisy[::-1].copy()[::-1]):
        assert np.array_equal(denoise(same), expected)


ONES = np.ones((4, 5, 3))


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((ONES[..., 0],), r"picture to denoise must be of shape \(height, width, 3\), not \(4, 5\)"),
        ((np.ones((4, 5, 4)),), r"not \(4, 5, 4\)"),
        ((np.ones((0, 5, 3)),), r"not \(0, 5, 3\)"),
        ((ONES, ONES[:3]), r"albedo is of shape \(3, 5, 3\), but the picture to denoise of \(4, 5, 3\)"),
        ((ONES, ONES, ONES[..., :1]), "normal to denoise must be"),
        ((ONES, None, ONES), "without an albedo"),
        ((ONES.astype(complex),), "real numbers"),
    ],
)
def test_what_cannot_be_denoised_says_so(arguments, said):
    with pytest.raises(DenoiseError, match=said):
        denoise(*arguments)


def test_a_missing_package_says_how_to_install_it(monkeypatch):
    monkeypatch.delitem(sys.modules, "mitsuba_oidn", raising=False)
    original = builtins.__import__

    def without(name, *arguments, **keywords):
        if name == "mitsuba_oidn":
            raise ModuleNotFoundError(f"No module named '{name}'")
        return original(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(TracerError, match=r'mitsuba-oidn.*pip install "\.\[denoise\]"'):
        denoise(ONES)


def test_the_last_filter_is_kept_for_the_next_picture(monkeypatch):
    from tracer.denoising import oidn

    images = [np.random.default_rng(0).random((size, size, 3)).astype(np.float32) for size in (40, 48)]
    first = [denoise(image) for image in images]
    assert len(oidn.last_filter) == 1
    (last,) = oidn.last_filter.values()
    assert np.array_equal(denoise(images[1]), first[1])
    assert next(iter(oidn.last_filter.values())) is last
    assert np.array_equal(denoise(images[0]), first[0])
    assert np.array_equal(denoise(images[0], images[0], images[0]), denoise(images[0], images[0], images[0]))
    monkeypatch.setattr(oidn, "MOST_KEPT", 100)  # it holds memory
    assert np.array_equal(denoise(images[1]), first[1])
    assert not oidn.last_filter


def test_one_filter_runs_at_a_time(monkeypatch):
    from tracer.denoising import oidn

    images = [np.random.default_rng(k).random((40, 40, 3)).astype(np.float32) for k in range(6)]
    expected = [denoise(image) for image in images]
    running, most, run = [], [], oidn.run

    def counted(*arguments):
        running.append(1)
        most.append(len(running))
        time.sleep(0.01)
        result = run(*arguments)
        running.pop()
        return result

    monkeypatch.setattr(oidn, "run", counted)
    with ThreadPoolExecutor(4) as threads:
        together = list(threads.map(denoise, images))
    assert max(most) == 1
    assert all(np.array_equal(*pair) for pair in zip(expected, together, strict=True))
