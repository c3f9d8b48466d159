"""The front door: what is refused before the first sample, whoever asks."""

import gc

import numpy as np
import pytest

import tracer
from conftest import small_scene
from tracer.errors import OutputError
from tracer.session import render
from tracer.session.render import render_request
from tracer.session.render_loop import Rendering
from tracer.session.request import CheckpointFile, PictureFile, Request
from tracer.session.shards import Part


def test_names_that_cannot_be_written_are_refused_also_where_a_part_is_written_later(tmp_path):
    tracer.activate()
    aovs = {"type": "aov", "aovs": f"{'n' * 250}:depth", "image": {"type": "path"}}
    told = []
    part = Request(small_scene((4, 4)), {"spp": 4}, integrator=aovs, part=Part(1, 2), progress=told.append)
    for request in (part, Request(small_scene((4, 4)), integrator=aovs, picture=PictureFile(tmp_path / "out.exr"))):
        with pytest.raises(OutputError, match="more than 240 bytes"):
            render_request(request)
    assert told == []


def test_sums_are_let_go_before_the_picture_is_written(tmp_path, monkeypatch):
    tracer.activate()
    alive = []

    def write(*arguments):
        gc.collect()
        alive.append(any(isinstance(thing, Rendering) for thing in gc.get_objects()))

    monkeypatch.setattr(render, "write_picture", write)
    render_request(Request(small_scene((4, 4)), {"spp": 8}, picture=PictureFile(tmp_path / "out.exr")))
    assert alive == [False]


def test_a_view_that_is_open_is_rendered_with_its_own_settings(tmp_path):
    tracer.activate()
    scene = {**small_scene((4, 4)), "integrator": {"type": "adaptive", "criterion": "uniform", "spp": 3}}
    with tracer.scene.view.open_scene(scene) as view:
        file = CheckpointFile(tmp_path / "state.ckpt")
        result = render_request(Request(view, {"seed": 5}, checkpoint=file))
    assert (result.report.settings.criterion, result.report.settings.spp) == ("uniform", 3)
    assert np.array_equal(result.image, tracer.render(scene, seed=5).image)
    assert file.path.exists()
