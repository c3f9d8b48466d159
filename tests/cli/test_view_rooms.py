"""Commands ``view ...`` of rooms: what they write and say."""

import json

import numpy as np
import pytest

from cli.views import FEW, call, names_in
from tracer.errors import TracerError

ROOM = """<scene version="3.0.0">
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="-1.5,-1.5,0" target="1,1,-0.5" up="0,0,1"/></transform>
    </sensor>
    <shape type="cube" id="shell"><transform name="to_world"><scale x="2" y="2" z="1.3"/></transform></shape>
    <shape type="cube" id="box"><transform name="to_world"><scale value="0.3"/><translate z="-1"/></transform></shape>
    <emitter type="point"><point name="position" x="0" y="0" z="1"/></emitter>
</scene>"""


@pytest.fixture
def interior(tmp_path):
    path = tmp_path / "room.xml"
    path.write_text(ROOM)
    return path


def test_a_room_is_looked_at_from_inside(interior, tmp_path):
    said = call("best", interior, "--surfaces", "shape", "-o", tmp_path / "in", "--side", 32)
    assert "The scene is a room" in said
    assert names_in(tmp_path / "in") == ["best.json", "best.png", "camera.xml", "plan.png"]
    report = json.loads((tmp_path / "in" / "best.json").read_text())
    assert np.all(np.abs(report["eye"]) < [2, 2, 1.3])
    call("best", interior, "--outside", "--search", "paper", "-o", tmp_path / "out", *FEW)
    assert "sphere.png" in names_in(tmp_path / "out")
    with pytest.raises(TracerError, match="mean nothing"):
        call("best", interior, "--inside", "--distance", 9, "-o", tmp_path / "none", *FEW)
    for more, said in ((["--random", 99], "leave out --random"), (["--search", "paper"], "leave out --search")):
        with pytest.raises(TracerError, match=said):
            call("best", interior, *more, "-o", tmp_path / "none", *FEW)
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize(("command", "more"), [("measure", ["-m", "visible"]), ("cover", [])])
def test_that_a_room_is_looked_at_from_outside_is_said(command, more, interior, scene, tmp_path):
    few = ["--level", 0, "--side", 32, "--surfaces", "shape", *more]
    sentence = "The scene is a room, and is looked at from outside here"
    assert call(command, interior, "-o", tmp_path / "room", *few).count(sentence) == 1
    assert sentence not in call(command, interior, "-o", tmp_path / "far", "--distance", 20, *few)
    assert sentence not in call(command, scene, "-o", tmp_path / "thing", *few)


def test_a_tour_inside(interior, tmp_path):
    few = ["--steps", 3, "--frames", 4, "--size", 32]
    call("tour", interior, "--surfaces", "shape", "-o", tmp_path / "tour", *few, *FEW)
    assert {"path.png", "path.csv", "cameras.xml", "tour.webp", "frame0003.png"} <= set(names_in(tmp_path / "tour"))


def test_inside_of_what_has_no_inside(tmp_path):
    path = tmp_path / "flat.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(TracerError, match="no place inside"):
        call("best", path, "--inside", "-o", tmp_path / "none", *FEW)
    assert not (tmp_path / "none").exists()
