"""Pictures by other renderers, as they write them."""

import numpy as np
import pytest

from tracer.errors import LayerError, OutputError, ScoreError
from tracer.image.colour import decode_srgb, encode_srgb
from tracer.io.exr import write_exr, write_png
from tracer.io.images import layers, read_picture, read_reference, score_pair

RGB = np.random.default_rng(0).random((8, 9, 3)).astype(np.float32)


def exr(path, names, values):
    write_exr(path, names, values.astype(np.float32), {})
    return path


def test_plain_and_our_own(tmp_path):
    path = exr(tmp_path / "a.exr", ["R", "G", "B", "A"], np.concatenate([RGB, RGB[..., :1]], axis=-1))
    np.testing.assert_array_equal(read_picture(path), RGB)
    names = ["R", "G", "B", "samples.Y", "stderr.R", "stderr.G", "stderr.B", "complexity.Y"]
    path = exr(tmp_path / "b.exr", names, np.concatenate([RGB, np.ones((8, 9, 5))], axis=-1))
    np.testing.assert_array_equal(read_picture(path), RGB)
    np.testing.assert_array_equal(read_picture(path, "stderr"), np.ones((8, 9, 3)))


def test_blenders_layers(tmp_path):
    names = [f"ViewLayer.{layer}.{c}" for layer in ("Combined", "DiffDir") for c in "BGR"] + ["ViewLayer.Depth.Z"]
    values = np.concatenate([RGB[..., ::-1], np.zeros((8, 9, 4))], axis=-1)
    np.testing.assert_array_equal(read_picture(exr(tmp_path / "c.exr", names, values)), RGB)


def test_pictures_for_a_screen_become_linear(tmp_path):
    write_png(tmp_path / "a.png", encode_srgb(RGB))
    np.testing.assert_allclose(read_picture(tmp_path / "a.png"), RGB, atol=5e-3)
    np.testing.assert_allclose(decode_srgb(encode_srgb(RGB)), RGB, atol=1e-6)
    assert decode_srgb(0.5) == pytest.approx(0.214041, abs=1e-6)


def test_several_parts(tmp_path):
    import OpenImageIO as oiio

    path = tmp_path / "parts.exr"
    specifications = [oiio.ImageSpec(9, 8, count, "float") for count in (1, 3)]
    specifications[0].channelnames = ("Z",)
    for name, specification in zip(("depth", "beauty"), specifications, strict=True):
        specification.attribute("oiio:subimagename", name)
    output = oiio.ImageOutput.create(str(path))
    output.open(str(path), tuple(specifications))
    output.write_image(np.zeros((8, 9, 1), np.float32))
    output.open(str(path), specifications[1], "AppendSubimage")
    output.write_image(RGB)
    output.close()
    np.testing.assert_array_equal(read_picture(path), RGB)


def test_layers():
    assert layers(["R", "G", "B", "a.b.R", "a.b.G", "a.b.B"]) == {"": [0, 1, 2], "a.b": [3, 4, 5]}
    assert layers(["Y", "A", "samples.Y"]) == {"": [0], "samples": [2]}
    assert layers(["X", "Y", "Z", "N.X", "N.Y", "N.Z"]) == {}
    assert layers(["R", "B"]) == {}


def test_mistakes(tmp_path):
    with pytest.raises(ScoreError, match="There is no picture"):
        read_picture(tmp_path / "no.exr")
    (tmp_path / "text.exr").write_text("no picture")
    with pytest.raises(OutputError, match="Cannot read"):
        read_picture(tmp_path / "text.exr")
    with pytest.raises(ScoreError, match="no channels R, G and B"):
        read_picture(exr(tmp_path / "z.exr", ["Z"], RGB[..., :1]))
    two = exr(tmp_path / "two.exr", ["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"], np.concatenate([RGB, RGB], axis=-1))
    with pytest.raises(ScoreError, match=r"several layers; choose one with --layer: a, b"):
        read_picture(two)
    with pytest.raises(ScoreError, match=r"no layer 'c'.*a, b"):
        read_picture(two, "c")
    spoilt = RGB.copy()
    spoilt[0, :2, 1] = np.nan
    with pytest.raises(ScoreError, match=r"2 pixels of .* are not finite"):
        read_picture(exr(tmp_path / "nan.exr", ["R", "G", "B"], spoilt))
    with pytest.raises(ScoreError, match="'a' is 9 x 8 pixels and 'b' is 8 x 8"):
        score_pair("a", RGB, "b", RGB[:, 1:])
    with pytest.raises(ScoreError, match="'b' is grey and 'a' is in colour"):
        score_pair("a", RGB, "b", RGB[..., :1])
    with pytest.raises(ScoreError, match="'a' is 9 x 6 pixels, and structural similarity needs at least 7 a side"):
        score_pair("a", RGB[:6], "b", RGB[:6])
    assert [one.shape for one in score_pair("a", RGB[..., :1], "b", RGB[..., :1])] == [(8, 9, 3)] * 2


def test_a_reference_needs_no_layer_of_the_pictures(tmp_path):
    other = 0.5 * RGB
    plain = exr(tmp_path / "plain.exr", ["R", "G", "B"], RGB)
    both = exr(tmp_path / "both.exr", [*"RGB", *(f"noisy.{c}" for c in "RGB")], np.concatenate([RGB, other], axis=-1))
    for path, layer, expected, taken in (
        (plain, "noisy", RGB, None),
        (both, "noisy", other, "noisy"),
        (both, None, RGB, None),
        (both, "stderr", RGB, None),
    ):
        values, found = read_reference(path, layer)
        np.testing.assert_array_equal(values, expected)
        assert found == taken
    with pytest.raises(LayerError, match="no layer 'noisi', did you mean 'noisy'"):
        read_picture(both, "noisi")
    with pytest.raises(ScoreError, match="There is no picture"):
        read_reference(tmp_path / "none.exr", "noisy")
