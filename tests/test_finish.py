"""Features and denoising of a render: along its own rays, in every kind of film."""

import numpy as np
import pytest

import tracer
from tracer import files
from tracer.errors import DenoiseError
from tracer.metadata import metadata
from tracer.score import luminance


def test_features_are_layers(cornell, tmp_path):
    result = tracer.render(cornell(), spp=8, features=True)
    seen = result.seen
    assert seen.features.albedo.shape == (16, 24, 3)
    assert 0 < seen.features.depth.max() < 10
    assert len(seen.shape_names) >= seen.shapes.max() > 1
    files.write_result(tmp_path / "out.exr", result, metadata(result, "abc"))
    names, values, own = files.read_exr(tmp_path / "out.exr")
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

    with pytest.raises(DenoiseError, match=r"tracer\[denoise\]"):
        tracer.render(cornell(), spp=4, denoise=True, progress=drawn)
