"""``python -m benchmarks``: what it says of itself, and one sentence for every mistake."""

import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.__main__ import ABOUT, app
from conftest import PATIENCE
from tracer.cli import in_one_sentence

ROOT = Path(__file__).parents[2]


@pytest.fixture
def program(monkeypatch, capfd):
    """Run the program in this process; return exit code, standard output and standard error."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["benchmarks", *map(str, arguments)])
        with pytest.raises(SystemExit) as stopped:
            in_one_sentence(app)
        output = capfd.readouterr()
        return stopped.value.code or 0, output.out, output.err

    return run


def test_help_says_what_each_measures_and_how_long_it_takes():
    command = [sys.executable, "-m", "benchmarks", "--help"]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True, timeout=PATIENCE).stdout
    for name in ABOUT:
        (line,) = (line for line in said.splitlines() if line.startswith(f"│ {name} "))
        assert ABOUT[name] in line
        assert "minutes." in line


def test_every_benchmark_is_a_folder_and_has_a_command():
    folders = {path.parent.name for path in (ROOT / "benchmarks").glob("*/report.py")}
    assert folders == set(ABOUT)


def test_an_unknown_benchmark_is_one_sentence(program, tmp_path):
    code, out, error = program("radiosty", "-o", tmp_path / "out")
    assert (code, out) == (2, "")
    assert error == f"tracer: There is no benchmark 'radiosty'; there are: {', '.join(ABOUT)}.\n"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ABOUT)
def test_results_are_not_overwritten_unasked(program, name, tmp_path):
    (tmp_path / "results.json").write_text("{}")
    for folder in ("meshes", "molecules"):
        (tmp_path / folder).mkdir()
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / "scene.xml").write_text("<scene/>")
    public = [tmp_path] if name in ("guiding", "time", "viewpoint") else []
    code, out, error = program(name, *public, "-o", tmp_path)
    assert (code, out) == (2, "")
    assert error == (
        f"tracer: '{tmp_path / 'results.json'}' exists; choose another folder, or --overwrite to replace it.\n"
    )
    assert (tmp_path / "results.json").read_text() == "{}"


def test_there_must_be_something_to_go_on_with(program, tmp_path):
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / "scene.xml").write_text("<scene/>")
    code, _, error = program("time", tmp_path, "-o", tmp_path / "out", "--resume")
    assert code == 2
    assert error == f"tracer: There is no '{tmp_path / 'out' / 'results.json'}' to go on with.\n"
    assert not (tmp_path / "out").exists()


def test_a_folder_without_meshes_is_one_sentence(program, tmp_path):
    code, _, error = program("viewpoint", tmp_path, "-o", tmp_path / "out")
    assert code == 2
    assert error == f"tracer: There is no folder '{tmp_path / 'meshes'}'; name the folder that has it.\n"


def test_a_benchmark_is_run_and_says_where_its_results_are(program, tmp_path, monkeypatch):
    from benchmarks.bias import report

    monkeypatch.setattr(report, "report", lambda folder, progress: (folder / "results.md").write_text("done"))
    code, out, error = program("bias", "-o", tmp_path / "out")
    assert (code, error) == (0, "")
    assert out == f"{tmp_path / 'out' / 'results.md'} has everything.\n"
    assert (tmp_path / "out" / "results.md").read_text() == "done"
    assert program("bias", "-o", tmp_path / "out", "--overwrite", "-q") == (0, "", "")
