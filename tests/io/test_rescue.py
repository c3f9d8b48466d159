"""What does not fit where it was to go is kept elsewhere, and the message says where."""

import pytest

from tracer.errors import WriteError
from tracer.io import rescue


def writer(full):
    """Return a function that writes a file unless it is in one of the folders that are ``full``."""

    def write(path):
        if any(path.is_relative_to(folder) for folder in full):
            raise WriteError(f"Cannot write '{path}': No space left on device.")
        path.write_text("picture")

    return write


def test_what_fits_is_written_and_nothing_else(tmp_path):
    rescue.write_or_rescue(tmp_path / "out.exr", writer([]))
    assert [path.name for path in tmp_path.iterdir()] == ["out.exr"]


@pytest.fixture
def places(tmp_path, monkeypatch):
    """Return folders for temporary files, of the user and the current one, in this order."""
    folders = [tmp_path / name for name in ("temporary", "home", "here")]
    for folder in folders:
        folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folders[0]))
    monkeypatch.setenv("HOME", str(folders[1]))
    monkeypatch.chdir(folders[2])
    return folders


@pytest.mark.parametrize("full", [0, 1, 2])
def test_the_first_place_with_room_takes_it(tmp_path, places, full):
    (tmp_path / "wanted").mkdir()
    write = writer([tmp_path / "wanted", *places[:full]])
    with pytest.raises(WriteError) as raised:
        rescue.write_or_rescue(tmp_path / "wanted" / "out.exr", write)
    (kept,) = places[full].rglob("out.exr")
    assert kept.read_text() == "picture"
    assert str(raised.value) == (
        f"Cannot write '{tmp_path}/wanted/out.exr': No space left on device. The picture is kept as '{kept}'."
    )
    assert not any(list(folder.iterdir()) for folder in places[:full])


def test_no_room_at_all_is_said(tmp_path, places):
    with pytest.raises(WriteError, match=r"out\.exr'.* There was no room for the picture anywhere else\.$"):
        rescue.write_or_rescue(tmp_path / "out.exr", writer([tmp_path]))
    assert not any(list(folder.iterdir()) for folder in places)
