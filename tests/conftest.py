"""Shared by all tests: the variant, small scenes, and a cache of references that is not the user's."""

import contextlib
import ctypes
import os
import resource
import sys
from pathlib import Path

import pytest
from hypothesis import settings

import tracer
from tracer.adaptive import prediction

settings.register_profile("same_every_time", derandomize=True, deadline=None)  # a machine may be slow
settings.load_profile("same_every_time")
tracer.activate("llvm_ad_rgb")
sys.path.append(str(Path(__file__).parents[1]))  # for benchmarks, which are not installed; behind tracer, which is

import mitsuba as mi  # noqa: E402

QUICK = ("adaptive", "complexity", "image", "io")
"""Folders whose tests ``pytest -m quick`` runs; to import all others would take longer than these tests."""
PATIENCE = 500
"""Seconds after which a program that ends by itself is taken to hang, on however slow a machine."""


def pytest_ignore_collect(collection_path, config):
    """Leave out all but the folders of QUICK where only their tests are asked for."""
    is_asked_for = collection_path.name in QUICK or collection_path.parent != Path(__file__).parent
    return None if is_asked_for or config.option.markexpr != "quick" else True


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their marks
def pytest_collection_modifyitems(items):
    """Mark the tests in the folders of QUICK."""
    for item in items:
        if item.path.parent.name in QUICK and not any(item.iter_markers("slow")):
            item.add_marker("quick")


@pytest.fixture(scope="session", autouse=True)
def work_of_decision():
    """Let decisions pay in pictures as small as those of tests, and return what they are taken to cost otherwise."""
    usual = prediction.WORK_OF_DECISION
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prediction, "WORK_OF_DECISION", 0.0)
        patch.setattr(prediction, "WORK_OF_OBJECT", 0.0)
        yield usual


def small_scene(size=(24, 16), filter_name="gaussian", **film):
    """Return a Cornell box with a film of ``size`` (width, height), as a dictionary."""
    scene = mi.cornell_box()
    scene["sensor"]["film"] |= {"width": size[0], "height": size[1], "rfilter": {"type": filter_name}, **film}
    return scene


@pytest.fixture
def cornell():
    return small_scene


@pytest.fixture
def scene_file(tmp_path):
    """Write XML between <scene> tags to a file and return its path."""

    def write(body, name="scene.xml"):
        path = tmp_path / name
        path.write_text(f'<scene version="3.0.0">{body}</scene>')
        return path

    return write


SENSOR = (
    '<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="12"/>'
    '<integer name="height" value="8"/></film><sampler type="independent"/></sensor>'
)
LIT = f'<integrator type="path"/>{SENSOR}<emitter type="constant"/>'


@pytest.fixture(autouse=True)
def reference_cache(tmp_path, monkeypatch):
    """Keep references of tests out of the user's cache."""
    monkeypatch.setenv("TRACER_CACHE", str(tmp_path / "cache"))


@pytest.fixture(scope="session")
def two_workers():
    """Workers for all tests that do nothing to them, as they take seconds to start."""
    from tracer.cluster.connection import connected, own_cluster

    with own_cluster(2) as cluster, connected(cluster) as client:
        for name in ("WORK_OF_DECISION", "WORK_OF_OBJECT"):
            client.run(setattr, prediction, name, 0.0)  # as in this process
        yield client


@contextlib.contextmanager
def files_of_at_most(size):
    """Let no file of this process become larger than ``size`` bytes: writing more fails as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.fixture
def small_disk(tmp_path):
    """Return a function that makes a folder on a disk of its own, of so many bytes; only root can."""
    mounted = []
    library = ctypes.CDLL(None, use_errno=True)

    def make(size):
        folder = tmp_path / f"disk{len(mounted)}"
        folder.mkdir()
        if library.mount(b"tmpfs", str(folder).encode(), b"tmpfs", 0, f"size={size}".encode()):
            pytest.skip(f"no disk can be made here: {os.strerror(ctypes.get_errno())}")
        mounted.append(folder)
        return folder

    yield make
    for folder in mounted:
        library.umount(str(folder).encode())
