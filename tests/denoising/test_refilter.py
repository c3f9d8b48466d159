"""Pictures of pixel means come near to those through the film's filter."""

import json

import mitsuba as mi
import numpy as np
import pytest

import tracer
from conformance.cases import FILTERS, scene
from tracer.denoising.refilter import FilterShape, filtered_variance, refilter
from tracer.image import metrics

KNOWN = {"box": 1 / 12, "tent": 1 / 6, "mitchell": 1 / 9, "catmullrom": 0.0}


@pytest.mark.parametrize("name", KNOWN)
def test_variances_known_from_analysis(name):
    assert FilterShape.of(mi.load_dict({"type": name})).variance == pytest.approx(KNOWN[name], abs=1e-3)


@pytest.mark.parametrize("name", FILTERS)
def test_means_of_pixels_tell_of_their_part_of_the_noise(name):
    """Against the correlation of a filtered pixel with the best sum of pixel means, drawn by chance: within 0.01, four
    standard errors.
    """
    reconstruction = mi.load_dict({"type": name})
    pixels, samples = np.arange(-4, 5), 20000
    position = np.random.default_rng(2).random((2, samples))
    across, down = (
        np.array([np.asarray(reconstruction.eval(mi.Float(each - pixel - 0.5)).numpy()) for pixel in pixels])
        for each in position
    )
    weight = np.einsum("is,js->ijs", across, down)
    variance, told = (weight**2).mean(axis=-1).sum(), (weight.mean(axis=-1) ** 2).sum()
    assert FilterShape.of(reconstruction).hidden_share == pytest.approx(1 - told / variance, abs=0.01)


@pytest.mark.parametrize("name", FILTERS)
def test_a_constant_stays_and_a_point_gets_the_variance(name):
    reconstruction = FilterShape.of(mi.load_dict({"type": name}))
    assert refilter(np.full((5, 7, 3), 2.0), reconstruction) == pytest.approx(2.0)
    point = np.zeros((31, 31, 1))
    point[15, 15] = 1
    found = refilter(point, reconstruction)[..., 0]
    offset = np.arange(31) - 15
    for axis in (0, 1):
        expected = reconstruction.variance - 1 / 12
        assert found.sum(axis=axis) @ offset**2 == pytest.approx(expected, abs=1e-5)
    assert found.sum() == pytest.approx(1, abs=1e-5)


def test_wide_filters_are_taken_in_steps():
    wide = FilterShape.of(mi.load_dict({"type": "gaussian", "stddev": 2.0}))
    point = np.zeros((41, 41, 1))
    point[20, 20] = 1
    row = refilter(point, wide)[20, :, 0]
    assert np.all(np.diff(row[:21]) >= 0)
    assert np.all(row >= 0)


@pytest.mark.parametrize(("name", "nearer"), [("gaussian", 3), ("tent", 2)])
def test_nearer_to_the_picture_through_the_filter(name, nearer):
    def picture(filter_name):
        dictionary = scene(filter_name=filter_name)
        dictionary["sensor"]["film"] |= {"width": 48, "height": 36}
        return tracer.render(dictionary, spp=256, criterion="uniform").image[..., :3]

    means, expected = picture("box"), picture(name)
    found = refilter(means, FilterShape.of(mi.load_dict({"type": name})))
    assert metrics.relative_mse(found, expected) < metrics.relative_mse(means, expected) / nearer


def test_a_box_changes_nothing():
    image = np.random.default_rng(0).random((6, 5, 3)).astype(np.float32)
    assert np.array_equal(refilter(image, FilterShape.of(mi.load_dict({"type": "box"}))), image)


@pytest.mark.parametrize("name", FILTERS)
def test_variances_of_filtered_pictures(name):
    """Against pixels whose samples are drawn by chance, noise of variance 1 in each pixel: within 2 %."""
    reconstruction = mi.load_dict({"type": name})
    random, samples, size = np.random.default_rng(3), 256, 25
    reach = 0 if name == "box" else int(np.ceil(reconstruction.radius() - 0.5))
    position = random.random((2, samples, size, size))
    total, weights = np.zeros((size, size)), np.zeros((size, size))
    for down in range(-reach, reach + 1):
        for right in range(-reach, reach + 1):
            across, along = (
                np.ones_like(place)
                if name == "box"
                else np.asarray(reconstruction.eval(mi.Float((k + 0.5 - place).ravel())).numpy()).reshape(place.shape)
                for k, place in ((right, position[0]), (down, position[1]))
            )
            weight = across * along
            total += np.roll((weight**2).sum(axis=0), (down, right), axis=(0, 1))
            weights += np.roll(weight.sum(axis=0), (down, right), axis=(0, 1))
    expected = (total / weights**2 * samples)[5:-5, 5:-5].mean()
    found = filtered_variance(np.ones((size, size), np.float32), FilterShape.of(reconstruction))
    assert found[5:-5, 5:-5].mean() == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    "wrong",
    [
        {"variance": float("nan")},
        {"variance": 1e9},
        {"squared_weights": []},
        {"squared_weights": [0.5, 0.5]},
        {"squared_weights": ["a"]},
        {"hidden_share": 2.0},
        {"hidden_share": None},
    ],
)
def test_shapes_are_kept_as_plain_values_and_damage_is_noticed(wrong):
    shape = FilterShape.of(mi.load_dict({"type": "gaussian"}))
    assert FilterShape.from_plain(json.loads(json.dumps(shape.plain()))) == shape
    with pytest.raises((ValueError, TypeError)):
        FilterShape.from_plain({**shape.plain(), **wrong})
