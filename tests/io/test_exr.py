"""Pictures in layered EXR and in PNG."""

import numpy as np
import pytest

from conftest import files_of_at_most
from tracer.errors import OutputError, WriteError
from tracer.io import exr


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        ("one error", "one error"),
        ("first:\n\n  second.\n", "first; second"),
        ("", "it is damaged"),
        (b"a\xffb", "a\ufffdb"),
    ],
)
def test_what_openimageio_says_is_one_line(answer, expected):
    class Speaker:
        def geterror(self):
            return answer.decode() if isinstance(answer, bytes) else answer

    assert exr.said(Speaker()) == expected


def exr_of(path, values):
    exr.write_exr(path, [f"layer{k}.Y" for k in range(values.shape[2])], values, {})


def png_of(path, values):
    exr.write_png(path, values[..., :3])


@pytest.mark.parametrize(("name", "write"), [("out.exr", exr_of), ("out.png", png_of)])
def test_a_picture_that_does_not_fit_is_never_taken_to_be_written(tmp_path, name, write):
    # OpenImageIO itself says nothing of a PNG that is cut off anywhere, nor of an EXR without its last bytes.
    values = np.random.default_rng(0).random((48, 40, 6)).astype(np.float32)
    path = tmp_path / name
    write(path, values)
    size = path.stat().st_size
    path.unlink()
    for limit in (0, 100, size // 2, size - 2000, size - 100, size - 1):
        with files_of_at_most(limit), pytest.raises(WriteError) as raised:
            write(path, values)
        assert str(path) in str(raised.value) or f"'{name}'" in str(raised.value)
        assert f".{path.stem}." not in str(raised.value)  # the temporary name
        assert list(tmp_path.iterdir()) == []
    with files_of_at_most(size):
        write(path, values)
    assert path.stat().st_size == size


def test_only_what_would_collide_is_renamed():
    channels = ["R", "G", "B", "albedo.R", "albedo.G", "dd.y.T", "depth.T", "a.T", "a.T"]
    assert exr.own_names(channels, {"stderr", "samples"}) == [*channels[:-1], "2.a.T"]
    renamed = exr.own_names(channels, {"stderr", "albedo", "depth"})
    assert renamed == ["R", "G", "B", "aov.albedo.R", "aov.albedo.G", "dd.y.T", "aov.depth.T", "a.T", "2.a.T"]


def test_names_that_an_exr_cannot_hold_are_refused_before_the_work():
    exr.check_channels(["R", "n" * 240])
    with pytest.raises(OutputError, match="more than 240 bytes"):
        exr.check_channels(["R", "n" * 241])
    with pytest.raises(OutputError, match="more than 240 bytes"):
        exr.check_channels(["R", "\u00e9" * 121])


def test_values_of_another_kind_are_written_as_float32(tmp_path):
    values = np.random.default_rng(0).random((20, 3, 1))
    exr.write_exr(tmp_path / "a.exr", ["R"], values, {})
    assert np.array_equal(exr.read_exr(tmp_path / "a.exr")[1], values.astype(np.float32))
