"""What a render survives: being killed at any moment, being stopped, a disk that is full, a crash of Mitsuba."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from conftest import LIT, PATIENCE
from tracer import scenes
from tracer.io.atomic import is_running
from tracer.io.exr import read_exr, write_exr
from tracer.session import checkpoint

SIZE = LIT.replace('value="12"', 'value="96"').replace('value="8"', 'value="64"')
BALL = '<shape type="sphere"><bsdf type="roughconductor"/></shape>'
MOMENTS = 5


@pytest.fixture
def scene(scene_file):
    return scene_file(SIZE + BALL)


def command(scene, folder, *options, spp=4096):
    checkpoint_options = ["--checkpoint", folder / "state.ckpt", "--checkpoint-every", "0"]
    arguments = ["render", scene, "-o", folder / "out.exr", "--spp", spp, *checkpoint_options, *options]
    return [sys.executable, "-m", "tracer", *map(str, arguments)]


def start(arguments, **keywords):
    return subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **keywords)


def finish(arguments):
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def seconds_to_begin(arguments, state):
    """Return how long a render takes to its first checkpoint, as slow as the machine is."""
    began = time.monotonic()
    process = start(arguments)
    while not state.exists():
        assert process.poll() is None
        time.sleep(0.02)
    seconds = time.monotonic() - began
    process.kill()
    process.communicate()
    return seconds


@pytest.mark.slow
def test_killed_at_any_moment_it_goes_on_or_begins_again(tmp_path):
    """SIGKILL at random moments of a render that writes its checkpoint after every pass, also while it writes."""
    straight, killed = tmp_path / "straight", tmp_path / "killed"
    straight.mkdir()
    killed.mkdir()
    scene = Path(scenes.__file__).parent / "spheres_and_rods.xml"
    long = {"spp": 1 << 11}
    options = ("--size", 96, "--noise", 1e-6)  # which keeps it deciding round after round
    random = np.random.default_rng(7)
    samples = []
    begun = seconds_to_begin(command(scene, tmp_path, *options, **long), tmp_path / "state.ckpt")
    for moment in begun * random.uniform(0.2, 2.5, MOMENTS):
        process = start(command(scene, killed, "--resume", *options, **long))
        with pytest.raises(subprocess.TimeoutExpired):
            process.communicate(timeout=moment)
        process.kill()
        process.communicate()
        if (killed / "state.ckpt").exists():
            found = checkpoint.read(killed / "state.ckpt")  # raises if it is not whole
            samples.append(found.plain["done"])
    assert len(set(samples)) > 1  # how far it comes in between depends on the machine
    assert samples == sorted(samples)
    finish(command(scene, killed, "--resume", *options, **long))
    finish(command(scene, straight, *options, **long))
    pictures = [read_exr(folder / "out.exr") for folder in (straight, killed)]
    assert np.array_equal(pictures[0][1], pictures[1][1])
    assert sorted(path.name for path in killed.iterdir()) == ["out.exr", "state.ckpt"]  # nothing is left behind


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_stopped_it_keeps_what_there_is_and_goes_on(scene, tmp_path, number):
    process = start(command(scene, tmp_path, "--json", spp=20000))
    while not (tmp_path / "state.ckpt").exists():
        time.sleep(0.05)
        assert process.poll() is None
    process.send_signal(number)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 128 + number, err
    said = json.loads(out)
    assert said["stopped_by"] == "person"
    names, values, own = read_exr(tmp_path / "out.exr")
    assert own["complete"] == 0
    drawn = values[..., names.index("samples.Y")].sum()
    assert drawn == checkpoint.read(tmp_path / "state.ckpt").plain["done"]
    more = int(drawn / (96 * 64)) + 50
    resumed = json.loads(finish(command(scene, tmp_path, "--json", "--resume", spp=more)))
    assert resumed["complete"]
    names, values, _ = read_exr(tmp_path / "out.exr")
    assert values[..., names.index("samples.Y")].sum() == more * 96 * 64


@pytest.mark.slow
def test_on_a_full_disk_the_old_checkpoint_stays(scene, tmp_path):
    finish(command(scene, tmp_path, spp=16))
    before = (tmp_path / "state.ckpt").read_bytes()
    limit = len(before) // 2

    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    process = start(command(scene, tmp_path, "--resume", spp=64), preexec_fn=small_files)
    out, err = process.communicate(timeout=PATIENCE)
    assert "Traceback" not in err
    assert "Cannot write" in out + err
    assert (tmp_path / "state.ckpt").read_bytes() == before
    assert sorted(path.name for path in tmp_path.iterdir() if path.suffix == ".ckpt") == ["state.ckpt"]
    finish(command(scene, tmp_path, "--resume", spp=64))


@pytest.mark.slow
def test_a_crash_is_a_sentence(scene, tmp_path):
    crash = "import os, tracer.session.render_loop as loop\nloop.Rendering.run = lambda self: os.kill(os.getpid(), 11)"
    program = f"{crash}\nimport sys\nfrom tracer.cli import main\nmain()"
    arguments = [sys.executable, "-c", program, *command(scene, tmp_path)[3:]]
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 3
    assert done.stderr.startswith("tracer: Mitsuba crashed (SIGSEGV)")
    assert not (tmp_path / "out.exr").exists()


HANGS = """
import sys, threading
import tracer.session.render_loop as loop
from tracer.cli import main

def hang(self, finished):
    import drjit as dr, mitsuba as mi
    self.keeper.save_if_due(self.state)
    if self.keeper.kept:
        dr.set_thread_count(1)
        mi.Bitmap("picture.exr")  # which Mitsuba waits for with one thread, for ever
    return True

loop.Rendering.keep_and_tell = hang
main()
"""


@pytest.mark.slow
def test_what_hangs_in_mitsuba_ends_on_one_signal_with_its_checkpoint(scene, tmp_path, monkeypatch):
    monkeypatch.setenv("TRACER_GRACE", "4")
    write_exr(tmp_path / "picture.exr", ["R", "G", "B"], np.ones((64, 64, 3), np.float32), {})
    program = [sys.executable, "-c", HANGS, *command(scene, tmp_path, spp=10**6)[3:]]
    process = start(program, cwd=tmp_path)
    while not (tmp_path / "state.ckpt").exists():
        time.sleep(0.05)
        assert process.poll() is None
    time.sleep(2.0)
    process.send_signal(signal.SIGTERM)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 143
    assert err.startswith("tracer: killed, as it did not end after SIGTERM")
    samples = checkpoint.read(tmp_path / "state.ckpt").plain["done"]
    assert samples > 0
    finish(command(scene, tmp_path, "--resume", spp=samples // (96 * 64) + 8))


WORKERS_HANG = """
import os, time
from tracer.cluster import worker_task

def sleep_with_the_lock(*arguments):
    import ctypes
    os.write(1, b"%d\\n" % os.getpid())  # one write, as print's two of both workers may interleave
    ctypes.PyDLL(None).sleep(1000)  # holds Python's lock, as code of Mitsuba may

worker_task.draw_on_device = sleep_with_the_lock
"""
LOADS_MORE = """
import distributed
from tracer.cli import main

cluster = distributed.LocalCluster
distributed.LocalCluster = lambda preload, **options: cluster(preload=[preload, "hangs"], **options)
main()
"""


@pytest.mark.slow
def test_workers_that_hang_end_with_the_program(scene, tmp_path, monkeypatch):
    (tmp_path / "hangs.py").write_text(WORKERS_HANG)
    monkeypatch.setenv("TRACER_GRACE", "4")
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}")
    process = start([sys.executable, "-c", LOADS_MORE, *command(scene, tmp_path, "--workers", "2")[3:]], bufsize=1)
    workers = [int(process.stdout.readline()) for _ in range(2)]
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=60)
    assert process.returncode == 143
    time.sleep(0.5)
    assert not any(is_running(worker) for worker in workers)


@pytest.mark.slow
def test_nobody_renders_on_when_the_program_was_killed(scene, tmp_path):
    process = start(command(scene, tmp_path, spp=10**6))
    while not (tmp_path / "state.ckpt").exists():
        time.sleep(0.05)
    children = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True, check=False).stdout
    process.kill()
    process.communicate()
    while any(is_running(int(child)) for child in children.split()):  # for ever, if one renders on
        time.sleep(0.05)
