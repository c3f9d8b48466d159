"""Files are whole or not there."""

from pathlib import Path

import pytest

from tracer.errors import OutputError
from tracer.io import atomic, exr


def test_a_failed_write_leaves_what_was_there(tmp_path):
    path = tmp_path / "table.txt"
    atomic.write_text(path, "old")

    def fail():
        with atomic.whole(path) as temporary:
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
        ("there.exr", "exists; choose another name, or overwrite=True"),
        ("folder.exr", "is a folder"),
        ("no/out.exr", "There is no folder"),
        ("out.jpg", "must end in .exr or .png"),
    ):
        with pytest.raises(OutputError, match=message):
            atomic.check_output(tmp_path / name)
    assert atomic.check_output(tmp_path / "there.exr", overwrite=True)
    with pytest.raises(OutputError, match="Cannot read"):
        exr.read_exr(tmp_path / "there.exr")


def test_a_folder_that_cannot_be_written(tmp_path):
    with pytest.raises(OutputError, match="Cannot write in folder"):
        atomic.check_output(Path("/proc/out.exr"))
    (tmp_path / "compare.json").write_text("")
    with pytest.raises(OutputError, match=r"compare\.json' exists"):
        atomic.prepare_folder(tmp_path, False, ("compare.json",))


def test_a_number_that_no_process_has_is_nobodys():
    assert atomic.is_running(10**30)
