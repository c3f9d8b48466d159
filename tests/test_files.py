"""Files are whole or not there."""

import json

import numpy as np
import pytest

import tracer
from tracer import files
from tracer.errors import OutputError
from tracer.metadata import metadata


@pytest.fixture
def result(cornell):
    return tracer.render(cornell(pixel_format="rgba"), spp=8, seed=3)


def test_exr_holds_all_layers_and_metadata(tmp_path, result):
    path = tmp_path / "out.exr"
    files.write_result(path, result, metadata(result, "abc"))
    names, values, own = files.read_exr(path)
    stderr = [f"stderr.{c}" for c in "RGBA"]
    single = ("samples", "complexity", "importance", "cost")
    assert sorted(names) == sorted([*"RGBA", *stderr, *(f"{name}.Y" for name in single)])

    def layer(*wanted):
        return values[..., [names.index(name) for name in wanted]]

    assert np.array_equal(layer(*"RGBA"), result.image)
    assert np.array_equal(layer("samples.Y")[..., 0], result.samples.astype(np.float32))
    assert np.array_equal(layer(*stderr), result.stderr)
    for name in single[1:]:
        assert np.array_equal(layer(f"{name}.Y")[..., 0], getattr(result, name))
    assert values.dtype == np.float32
    expected = {"spp": 8, "seed": 3, "criterion": "fused", "objective": "relative", "scene_hash": "abc", "complete": 1}
    assert {name: own[name] for name in expected} == expected
    assert own["seconds"] == pytest.approx(result.seconds, rel=1e-6)
    assert json.loads(own["report"])["settings"]["spp"] == 8
    assert [path.name for path in tmp_path.iterdir()] == ["out.exr"]


def test_a_part_of_a_picture_is_shown_in_its_place(tmp_path, cornell):
    part = tracer.render(cornell(), spp=4, criterion="uniform", crop=(5, 3, 7, 6))
    files.write_result(tmp_path / "part.exr", part, {})
    with files.opened(tmp_path / "part.exr") as source:
        found = source.spec()
    assert (found.x, found.y, found.width, found.height) == (5, 3, 7, 6)
    assert (found.full_x, found.full_y, found.full_width, found.full_height) == (0, 0, 24, 16)


def test_png_is_what_a_screen_shows(tmp_path, result):
    files.write_result(tmp_path / "out.png", result, {})
    _, values, _ = files.read_exr(tmp_path / "out.png")
    assert values == pytest.approx(files.display(result.image), abs=0.6 / 255)


def test_a_failed_write_leaves_what_was_there(tmp_path):
    path = tmp_path / "table.txt"
    files.write_text(path, "old")

    def fail():
        with files.whole(path) as temporary:
            temporary.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["table.txt"]


def test_outputs_are_checked_before_the_work(tmp_path):
    (tmp_path / "there.exr").write_text("")
    (tmp_path / "folder.exr").mkdir()
    for name, message in (
        ("there.exr", "exists; choose another name, or --overwrite"),
        ("folder.exr", "is a folder"),
        ("no/out.exr", "There is no folder"),
        ("out.jpg", "must end in .exr or .png"),
    ):
        with pytest.raises(OutputError, match=message):
            files.check_output(tmp_path / name)
    assert files.check_output(tmp_path / "there.exr", overwrite=True)
    with pytest.raises(OutputError, match="Cannot read"):
        files.read_exr(tmp_path / "there.exr")


def test_a_folder_that_cannot_be_written(tmp_path):
    with pytest.raises(OutputError, match="Cannot write in folder"):
        files.check_output(files.Path("/proc/out.exr"))
    (tmp_path / "compare.json").write_text("")
    with pytest.raises(OutputError, match=r"compare\.json' exists"):
        files.prepare_folder(tmp_path, False, ("compare.json",))


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

    assert files.said(Speaker()) == expected
