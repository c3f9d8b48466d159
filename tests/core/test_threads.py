"""EXR files where the pool has one thread, in programs of their own: what goes wrong here never ends."""

import os
import subprocess
import sys
import threading

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.core import threads
from tracer.core.threads import COUNT, for_files
from tracer.errors import OutputError
from tracer.io.exr import write_exr

LONGEST = 240
"""Seconds for a program that takes 5 to 10 on a core of its own."""
SCENE = (
    '<integrator type="path"/><sensor type="perspective"><film type="hdrfilm"><integer name="width" value="16"/>'
    '<integer name="height" value="16"/></film><sampler type="independent"/></sensor>'
    '<emitter type="envmap"><string name="filename" value="environment.exr"/></emitter>'
    '<shape type="sphere"><transform name="to_world"><translate z="5"/></transform><bsdf type="diffuse">'
    '<texture type="bitmap" name="reflectance"><string name="filename" value="environment.exr"/></texture>'
    "</bsdf></shape>"
)
CALLBACK = """
import drjit as dr, tracer
tracer.activate()
import mitsuba as mi
dr.set_thread_count(1)

def look(now):
    mi.Bitmap("environment.exr")
    for name in ("image", "again"):
        mi.util.write_bitmap(f"{name}.exr", now.image)

found = tracer.render("scene.xml", spp=16, importance="environment.exr", progress=look)
assert dr.thread_count() == 1
assert 0 < found.image.mean() < 1
dr.set_thread_count(2)
assert tuple(mi.Bitmap("again.exr").size()) == (16, 16)
"""
CRITERION = """
from tracer import criteria
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
mi.Bitmap("environment.exr")

@criteria.criterion("from_file", needs_radiance=False)
def from_file(evidence):
    \"\"\"Return what a file says.\"\"\"
    return np.array(mi.Bitmap("environment.exr").resample(evidence.wanted.shape[::-1]))[..., 0]
"""
PLAN = """
name = "pinned"
spp = [8]
seeds = 1
reference_spp = 16
criteria = ["criterion.py"]
scenes = [{ path = "scene.xml" }]
methods = [{ name = "uniform", criterion = "uniform" }, { name = "from_file", criterion = "from_file" }]
"""


@pytest.fixture
def folder(scene_file, tmp_path):
    """Return a folder with a scene that has an EXR file as environment and as texture."""
    scene_file(SCENE)
    write_exr(tmp_path / "environment.exr", ["R", "G", "B"], np.full((32, 64, 3), 0.5, np.float32), {})
    return tmp_path


def pin():
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


def run(folder, *arguments, one_core=True):
    done = subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
        preexec_fn=pin if one_core else None,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_one_core_renders_a_scene_with_exr_files(folder):
    assert "16 x 16" in run(folder, "-m", "tracer", "render", "scene.xml", "-o", "out.exr", "--spp", 4)


@pytest.mark.slow
def test_workers_of_one_thread_do(folder):
    command = ["-m", "tracer", "render", "scene.xml", "-o", "out.exr", "--spp", 4, "--workers", 2]
    assert "16 x 16" in run(folder, *command, one_core=False)


def test_a_callback_reads_and_writes_exr_files_where_the_pool_was_set_to_one(folder):
    run(folder, "-c", CALLBACK, one_core=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        ["view", "measure", "scene.xml", "-o", "views", "-m", "entropy", "--level", 0, "--side", 16],
        ["view", "map", "scene.xml", "-o", "map"],
        ["radiosity", "scene.xml", "-o", "radiosity.exr"],
        ["compare", "scene.xml", "--spp", 4, "--seeds", 1, "--reference-spp", 16],
        ["render", "scene.xml", "-o", "out.exr", "--spp", 16, "--importance", "environment.exr", "--features"],
        ["render", "scene.xml", "-o", "out.exr", "--spp", 16, "--denoise", "--live", "now.png"],
        ["score", "environment.exr", "environment.exr"],
    ],
    ids=lambda command: " ".join(map(str, command[:2])),
)
def test_every_command_does_on_one_core(folder, command):
    run(folder, "-m", "tracer", *command)


@pytest.mark.slow
@pytest.mark.parametrize("more", [[], ["--workers", 2]])
def test_a_study_does_whose_criterion_reads_exr_files(folder, more):
    (folder / "criterion.py").write_text(CRITERION)
    (folder / "plan.toml").write_text(PLAN)
    run(folder, "-m", "tracer", "study", "plan.toml", "-o", "study", *more)


@pytest.fixture
def set_threads():
    """Yield a function that sets the number of threads, which are afterwards as many as before."""
    before = dr.thread_count()
    yield dr.set_thread_count
    dr.set_thread_count(before)


@pytest.mark.parametrize("own", [1, 2, COUNT, COUNT + 3])
def test_the_pool_is_as_it_was_before(set_threads, own):
    set_threads(own)
    with for_files():
        with for_files():
            assert dr.thread_count() == max(own, COUNT)
        assert dr.thread_count() == max(own, COUNT)
    assert dr.thread_count() == own


def test_embree_has_the_threads_that_the_pool_had_before(set_threads, monkeypatch):
    """It has no room for more than two a core, and crashes now and then where Mitsuba has offered it four on one."""
    found = []
    monkeypatch.setattr(threads.mi, "load_dict", lambda scene: found.append((scene, dr.thread_count())))
    threads.prepare_embree.cache_clear()
    set_threads(1)
    for _ in range(2):
        with for_files():
            pass
    assert found == [({"type": "scene"}, 1)]


def test_files_may_be_touched_before_there_is_a_variant(set_threads, monkeypatch):
    monkeypatch.setattr(threads.mi, "variant", lambda: None)
    monkeypatch.setattr(threads.mi, "load_dict", None)
    set_threads(1)
    with for_files():
        assert dr.thread_count() == COUNT


def test_what_the_block_sets_stays(set_threads):
    set_threads(1)
    with for_files():
        set_threads(2)
    assert dr.thread_count() == 2


def test_blocks_of_several_threads_end_with_the_last(set_threads):
    set_threads(1)
    entered, may_leave = threading.Event(), threading.Event()

    def other():
        with for_files():
            entered.set()
            may_leave.wait()

    thread = threading.Thread(target=other)
    with for_files():
        thread.start()
        entered.wait()
    assert dr.thread_count() == COUNT
    may_leave.set()
    thread.join()
    assert dr.thread_count() == 1


def test_a_file_that_is_still_being_written_is_whole_afterwards(set_threads, tmp_path):
    set_threads(1)
    picture = np.random.default_rng(1).random((300, 300, 3), np.float32)
    with for_files():
        for name in ("first.exr", "second.exr"):
            mi.util.write_bitmap(str(tmp_path / name), picture)
    set_threads(2)
    for name in ("first.exr", "second.exr"):
        assert np.array_equal(np.array(mi.Bitmap(str(tmp_path / name))), picture)


def test_a_file_that_cannot_be_written_is_named(set_threads, tmp_path):
    set_threads(1)
    path = tmp_path / "nowhere" / "picture.exr"
    with pytest.raises(OutputError, match=r"cannot be written: .*nowhere/picture\.exr"), for_files():
        mi.util.write_bitmap(str(path), np.zeros((4, 4, 3), np.float32))
    with for_files():
        pass
    assert dr.thread_count() == 1
