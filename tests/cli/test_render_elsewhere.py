"""Options of render that let others draw."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from conftest import PATIENCE
from tracer import scenes
from tracer.io.exr import read_exr

SCENE = Path(scenes.__file__).parent / "spheres_and_rods.xml"


def run(*arguments):
    command = [sys.executable, "-m", "tracer", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)


@pytest.mark.slow
def test_workers_write_the_same_picture(tmp_path):
    for name, more in (("alone.exr", []), ("workers.exr", ["--workers", 2])):
        done = run("render", SCENE, "-o", tmp_path / name, "--spp", 16, "--size", 64, "--json", *more)
        assert done.returncode == 0, done.stderr
        assert done.stderr == ""
        assert json.loads(done.stdout)["stopped_by"] == "spp"
    one, other = (read_exr(tmp_path / name)[1] for name in ("alone.exr", "workers.exr"))
    assert np.array_equal(one, other)


@pytest.mark.slow
def test_parts_need_no_picture(tmp_path):
    for number in (1, 2):
        path = tmp_path / f"{number}.ckpt"
        done = run("render", SCENE, "--part", f"{number}/2", "--checkpoint", path, "--spp", 8, "--size", 32)
        assert done.returncode == 0, done.stderr
        assert str(path) in done.stdout
    done = run("merge", tmp_path / "1.ckpt", tmp_path / "2.ckpt", "-o", tmp_path / "out.exr")
    assert done.returncode == 0, done.stderr
    assert ", 8 samples per pixel, " in done.stdout


def test_a_scheduler_that_is_not_there_is_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setenv("DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT", "1s")
    done = run("render", SCENE, "-o", tmp_path / "out.exr", "--scheduler", "nonsense://there")
    assert (done.returncode, done.stdout) == (4, "")
    assert done.stderr.startswith("tracer: Cannot connect to the scheduler 'nonsense://there'")
    assert done.stderr.count("\n") == 1
    both = run("render", SCENE, "-o", tmp_path / "out.exr", "--scheduler", "tcp://x:1", "--workers", 2)
    assert (both.returncode, both.stderr) == (2, "tracer: Name workers or a scheduler, not both.\n")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_a_terminal_says_to_all_processes_stops_without_loss(tmp_path, number):
    output, path = tmp_path / "out.exr", tmp_path / "state.ckpt"
    options = ["--spp", "20000", "--size", "128", "--workers", "2", "--checkpoint", str(path)]
    command = [sys.executable, "-m", "tracer", "render", str(SCENE), "-o", str(output), *options]
    program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, process_group=0)
    while not path.exists():  # after the first round
        assert program.poll() is None
        time.sleep(0.1)
    os.killpg(program.pid, number)
    out, err = program.communicate(timeout=PATIENCE)
    assert program.returncode == 128 + number, (out, err)
    assert "Stopped after" in out
    assert err == ""
    assert output.exists()
