"""The mixture is about as good as the better of two pictures, in whatever strips it is made."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.denoising import mixture as module
from tracer.denoising.mixture import HALO, Pictures, mixture
from tracer.denoising.refilter import FilterShape
from tracer.denoising.trust import SEEN

SIZE = (96, 128)
BOX = FilterShape(1 / 12, (1.0,), 0.0)


def pictures(noise, error, samples=32, seed=0):
    """Return the truth, and pictures with normal noise and with an error of the denoiser that does not vary."""
    random = np.random.default_rng(seed)
    truth = np.full((*SIZE, 3), 0.5, np.float32)
    noisy = (truth + noise * random.normal(size=truth.shape)).astype(np.float32)
    clean = (truth + error * np.sign(random.normal(size=truth.shape))).astype(np.float32)
    own = (noise**2 * random.chisquare(samples - 1, truth.shape) / (samples - 1)).astype(np.float32)
    return truth, Pictures(noisy, noisy.copy(), own, clean, np.full(SIZE, samples, np.float32))


@pytest.mark.parametrize("noise", [0.001, 0.01, 0.1])
@pytest.mark.parametrize("error", [0.0, 0.001, 0.01, 0.1])
def test_it_is_about_as_good_as_the_better_one(noise, error):
    truth, known = pictures(noise, error)
    errors = [np.mean((image - truth) ** 2) for image in (known.noisy, known.clean, mixture(known, BOX))]
    unseen = (SEEN * 0.5) ** 2  # noise as weak as this may stay
    assert errors[2] <= 1.2 * min(errors[:2]) + 0.05 * noise**2 + unseen


@pytest.mark.parametrize("name", ["box", "gaussian", "lanczos"])
@pytest.mark.parametrize("strip", [1, 7, 50])
def test_strips_change_nothing(monkeypatch, name, strip):
    shape = FilterShape.of(mi.load_dict({"type": name}))
    _, known = pictures(0.1, 0.03)
    known.noisy[30:33, 40:50] *= 1e4
    known.mean[30:33, 40:50] *= 1.1e4
    whole = mixture(known, shape)
    monkeypatch.setattr(module, "STRIP", strip)
    assert mixture(known, shape) == pytest.approx(whole, rel=2e-3, abs=1e-5)


@pytest.mark.filterwarnings("error")  # sums that overflow
@pytest.mark.parametrize("name", ["box", "gaussian"])
def test_a_pixel_beyond_all_bounds_spoils_no_other(name):
    shape = FilterShape.of(mi.load_dict({"type": name}))
    _, known = pictures(0.1, 0.01)
    expected = mixture(known, shape)
    bounds = ((known.noisy, 1e20), (known.mean, 1e20), (known.clean, 1e20), (known.squared_errors, 1e38))
    for picture, value in bounds:
        picture[50, 60] = value
    found = mixture(known, shape)
    assert np.all(np.isfinite(found))
    rows, columns = np.indices(known.count.shape)
    apart = np.maximum(abs(rows - 50), abs(columns - 60)) > HALO + shape.reach
    assert found[apart] == pytest.approx(expected[apart], abs=1e-3)


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (3, 2)])
@pytest.mark.parametrize("count", [0, 1, 3])
@pytest.mark.parametrize("value", [0.0, 0.7])
def test_small_and_black_pictures_with_few_samples(size, count, value):
    flat = np.full((*size, 3), value, np.float32)
    known = Pictures(flat, flat, 0 * flat, flat, np.full(size, count, np.float32))
    assert mixture(known, FilterShape.of(mi.load_dict({"type": "gaussian"}))) == pytest.approx(flat)


@pytest.mark.parametrize("error", [0.01, 0.1, 0.3])
def test_no_light_is_taken_that_was_not_there(error):
    """Pixels whose samples are bright where the filter gives them no weight: the detail outweighs what is left."""
    shape = FilterShape.of(mi.load_dict({"type": "gaussian"}))
    mean = np.full((*SIZE, 3), 0.5, np.float32)
    noisy = np.full_like(mean, 0.01)
    known = Pictures(noisy, mean, np.full_like(mean, error**2), noisy.copy(), np.full(SIZE, 4, np.float32))
    assert mixture(known, shape).min() >= 0
