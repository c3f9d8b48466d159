"""Features and denoising of a render: along its own rays, in every kind of film."""

import itertools
import math

import mitsuba as mi
import numpy as np
import pytest

import tracer
from conformance.cases import FILTERS
from tracer import result as output
from tracer.denoising import postprocess
from tracer.denoising.postprocess import without_noise
from tracer.denoising.refilter import FilterShape, evaluate
from tracer.errors import DenoiseError
from tracer.film.estimate import Statistics
from tracer.film.features import Features
from tracer.image import metrics
from tracer.image.colour import luminance
from tracer.io import exr
from tracer.result import metadata
from tracer.scene.frame import PlainFrame


def test_features_are_layers(cornell, tmp_path):
    result = tracer.render(cornell(), spp=8, features=True)
    seen = result.seen
    assert seen.features.albedo.shape == (16, 24, 3)
    assert 0 < seen.features.depth.max() < 10
    assert len(seen.shape_names) >= seen.shapes.max() > 1
    output.write_result(tmp_path / "out.exr", result, metadata(result, "abc"))
    names, values, own = exr.read_exr(tmp_path / "out.exr")
    assert values[..., names.index("depth.Z")] == pytest.approx(seen.features.depth)
    assert np.array_equal(values[..., names.index("shape.Y")], seen.shapes)
    assert values[..., [names.index(f"normal.{c}") for c in "XYZ"]] == pytest.approx(seen.features.normal)
    assert "floor" in own["shapes"]


@pytest.mark.parametrize("pixel_format", ["rgb", "rgba", "xyza", "luminance_alpha"])
def test_denoised_and_noisy_are_both_there(cornell, pixel_format):
    scene = cornell(size=(96, 64), pixel_format=pixel_format)
    noisy = tracer.render(scene, spp=4, criterion="uniform", seed=2)
    result = tracer.render(scene, spp=4, criterion="uniform", seed=2, denoise=True)
    colours = result.noisy.shape[-1]
    assert np.array_equal(result.noisy, noisy.image[..., :colours])
    assert np.array_equal(result.image[..., colours:], noisy.image[..., colours:])  # alpha
    assert result.image.shape == noisy.image.shape
    reference = tracer.render(scene, spp=256, criterion="uniform", seed=9).image
    errors = [np.median(abs(each.image - reference)[32:, :, :colours]) for each in (noisy, result)]
    assert errors[1] < 0.6 * errors[0]
    assert result.image[..., :colours].mean() == pytest.approx(noisy.image[..., :colours].mean(), rel=0.06)


def test_grey_and_coloured_films_are_denoised_alike(cornell):
    found = [
        tracer.render(cornell(pixel_format=name), spp=8, criterion="uniform", denoise=True).image
        for name in ("rgb", "luminance")
    ]
    assert found[1][..., 0] == pytest.approx(luminance(found[0]), rel=0.15, abs=0.1)


def test_what_is_denoised_is_the_unbiased_picture(cornell):
    settings = {"spp": 64, "unbiased": True, "seed": 4}
    result = tracer.render(cornell(), denoise=True, crop=(4, 2, 12, 10), **settings)
    assert result.image.shape == (10, 12, 3)
    assert np.array_equal(result.noisy, tracer.render(cornell(), crop=(4, 2, 12, 10), **settings).image)


def test_without_the_package_it_is_said_before_the_first_ray(cornell, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "mitsuba_oidn", None)

    def drawn(now):
        raise AssertionError

    with pytest.raises(DenoiseError, match=r"pip install \"\.\[denoise\]"):
        tracer.render(cornell(), spp=4, denoise=True, progress=drawn)


SIDE, SAMPLES_A_SIDE = 40, 8


def grey(x, y):
    return np.full_like(x, 0.3)


def disc(x, y):
    return np.where((x - 17.3) ** 2 + (y - 20.6) ** 2 < 9.0, 1e4, 0.3)


def small_lamps(x, y):
    """Of one pixel each, across the borders of pixels, a hundred to ten thousand."""
    at = [(6.2, 7.1, 1e2), (27.5, 9.4, 1e3), (12.8, 29.6, 1e4), (30.1, 31.9, 10.0)]
    return sum((value * ((abs(x - u) < 0.5) & (abs(y - v) < 0.5)) for u, v, value in at), grey(x, y))


def rods(x, y):
    return np.where(((x + 0.3 * y) % 13.0 < 0.6) & (y > 6), 300.0, 0.3)


def gradient(x, y):
    return 0.05 + np.exp(4.0 * x / SIDE) / 10


def dark_text(x, y):
    return np.where((x % 4.0 < 1.0) & (y % 9.0 < 6.0), 0.02, 0.8)


def simulated(truth, name, noise, fireflies=0.0):
    """Return a picture through the filter ``name``, its statistics, and the picture without noise.

    Every pixel has as many samples, stratified, each with normal noise, a part of its radiance, and rare light.
    """
    random = np.random.default_rng(5)
    cells = np.arange(SAMPLES_A_SIDE)
    shape = (SAMPLES_A_SIDE, SAMPLES_A_SIDE, SIDE, SIDE)
    u = (cells[:, None, None, None] + random.random(shape)) / SAMPLES_A_SIDE
    v = (cells[:, None, None] + random.random(shape)) / SAMPLES_A_SIDE
    column, row = np.arange(SIDE), np.arange(SIDE)[:, None]
    exact = truth(column + u, row + v)
    light = exact * (1.0 + noise * random.normal(size=shape)) + 50.0 * (random.random(shape) < fireflies)
    flat = [each.reshape(-1, SIDE, SIDE) for each in (u, v, light, exact)]
    mean, variance = flat[2].mean(axis=0), flat[2].var(axis=0, ddof=1)
    rfilter = mi.load_dict({"type": name})
    reach = 0 if name == "box" else math.ceil(rfilter.radius() - 0.5)
    sums = np.zeros((3, SIDE, SIDE))
    for down, right in itertools.product(range(-reach, reach + 1), repeat=2):
        across, along = (
            np.ones_like(each)
            if name == "box"
            else evaluate(rfilter, (offset + 0.5 - each).ravel()).reshape(each.shape)
            for offset, each in ((right, flat[0]), (down, flat[1]))
        )
        weight = across * along
        parts = [(weight * flat[2]).mean(0), (weight * flat[3]).mean(0), weight.mean(0)]
        target = [slice(max(k, 0), SIDE + min(k, 0)) for k in (down, right)]
        source = [slice(max(-k, 0), SIDE + min(-k, 0)) for k in (down, right)]
        for total, part in zip(sums, parts, strict=True):
            total[tuple(target)] += part[tuple(source)]
    image, expected = sums[0] / sums[2], sums[1] / sums[2]
    count = np.full((SIDE, SIDE), SAMPLES_A_SIDE**2, np.uint32)
    image, expected, mean, variance = (
        np.repeat(each[..., None], 3, axis=-1).astype(np.float32) for each in (image, expected, mean, variance)
    )
    nothing = np.zeros((SIDE, SIDE, 0), np.float32)
    return image, Statistics(count, 0 * count, mean, variance, 0 * count, nothing, nothing), expected


def finished(truth, name, noise, fireflies=0.0):
    """Return the noisy, the denoised and the true picture."""
    image, known, expected = simulated(truth, name, noise, fireflies)
    same = np.full((SIDE, SIDE, 3), 0.5, np.float32)
    frame = PlainFrame((SIDE, SIDE), 0, ["R", "G", "B"], 0, (0, 0, SIDE, SIDE))
    shape = FilterShape.of(mi.load_dict({"type": name}))
    return image, without_noise(frame, shape, Features(same, same, same[..., 0]), image, known), expected


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("truth", [disc, small_lamps, rods, dark_text, gradient])
@pytest.mark.parametrize("noise", [0.02, 0.3])
def test_denoised_is_no_worse_than_noisy_and_as_bright(truth, name, noise):
    noisy, found, expected = finished(truth, name, noise)
    nobody_sees = 1e-5  # a relative error of 0.3 %
    assert metrics.relative_mse(found, expected) < 1.05 * metrics.relative_mse(noisy, expected) + nobody_sees
    assert float(found.mean()) == pytest.approx(float(noisy.mean()), rel=0.01)


@pytest.mark.parametrize("channels", ["RGB", "XYZ"])
def test_errors_of_grey_noise_are_grey(monkeypatch, channels):
    frame = PlainFrame((16, 16), 0, list(channels), 0, (0, 0, 16, 16))
    deviation = frame.from_rgb(np.full((16, 16, 3), 0.2, np.float32))
    mean = frame.from_rgb(np.full((16, 16, 3), 0.5, np.float32))
    count, nothing = np.full((16, 16), 4, np.uint32), np.zeros((16, 16, 0), np.float32)
    known = Statistics(count, 0 * count, mean, deviation**2, 0.0 * count, nothing, nothing)
    seen = []
    monkeypatch.setattr(postprocess, "mixture", lambda pictures, shape: seen.append(pictures) or pictures.noisy)
    flat = np.zeros((16, 16, 3), np.float32)
    shape = FilterShape.of(mi.load_dict({"type": "box"}))
    without_noise(frame, shape, Features(flat, flat, flat[..., 0]), mean, known)
    assert seen[0].squared_errors == pytest.approx(np.full((16, 16, 3), 0.2**2 / 4), rel=1e-3)


def test_films_of_other_colours_are_denoised_alike(cornell):
    """Errors of XYZ are not those of RGB, but what is known of them is."""
    rgb, xyz = (
        tracer.render(cornell((48, 32), pixel_format=name), spp=8, criterion="uniform", denoise=True)
        for name in ("rgb", "xyz")
    )
    assert xyz.rgb == pytest.approx(rgb.rgb, rel=0.1, abs=0.05)
    assert np.mean((xyz.rgb - rgb.rgb) ** 2) < 0.05 * np.mean((rgb.noisy - rgb.rgb) ** 2)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("fireflies", [0.0, 1e-4])
@pytest.mark.parametrize("truth", [grey, gradient])
def test_noise_and_fireflies_go(truth, name, fireflies):
    noisy, found, expected = finished(truth, name, noise=1.0, fireflies=fireflies)
    assert metrics.relative_mse(found, expected) < 0.35 * metrics.relative_mse(noisy, expected)
    off = abs(float(noisy.mean()) / float(expected.mean()) - 1)
    assert float(found.mean()) == pytest.approx(float(expected.mean()), rel=0.01 + off)
