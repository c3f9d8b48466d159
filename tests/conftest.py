"""Shared by all tests: the variant, small scenes, and a cache of references that is not the user's."""

import pytest
from hypothesis import settings

import tracer

settings.register_profile("same_every_time", derandomize=True)
settings.load_profile("same_every_time")
tracer.activate("llvm_ad_rgb")

import mitsuba as mi  # noqa: E402


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
    from tracer.cluster.crew import connected, own_cluster

    with own_cluster(2) as cluster, connected(cluster) as client:
        yield client
