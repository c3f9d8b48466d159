"""The command line, called within this process."""

import sys

import pytest

from cli.views import SCENE
from tracer.cli import run


@pytest.fixture
def tracer_program(monkeypatch, capfd):
    """Run the program in this process; return exit code, standard output and standard error."""

    def program(*arguments):
        monkeypatch.setattr(sys, "argv", ["tracer", *map(str, arguments)])
        with pytest.raises(SystemExit) as stopped:
            run()
        output = capfd.readouterr()
        return stopped.value.code or 0, output.out, output.err

    return program


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text(SCENE)
    return path
