"""The work that is counted is that of the samples whose drawing is timed."""

import pytest

import tracer
from benchmarks.time import predicted
from benchmarks.time.page import predicted_table

SCENE = """
<integrator type="path"><integer name="max_depth" value="4"/></integrator>
<sensor type="perspective">
    <transform name="to_world"><lookat origin="0,0,6" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><rfilter type="box"/></film>
</sensor>
<shape type="sphere"/>
<emitter type="constant"/>
"""


def test_work_is_that_of_the_picture_and_seconds_are_of_every_turn(scene_file, monkeypatch):
    monkeypatch.setattr(predicted, "TURNS", 2)
    path = scene_file(SCENE)
    (row,) = predicted.predicted_rows("ball", path, (24, 16), 64)
    assert row["samples"] == 24 * 16 * 64
    assert {name: len(seconds) for name, seconds in row["drawing_seconds"].items()} == {"uniform": 2, "fused": 2}
    picture = tracer.render(path, size=(24, 16), spp=64, criterion="uniform", seed=predicted.SEED)
    assert row["work"]["uniform"] == pytest.approx(64 * picture.cost.sum(), rel=1e-5)


def test_what_is_predicted_stands_beside_what_was_measured():
    numbers = {"scene": "made up", "width": 8, "height": 4, "spp": 2, "samples": 64}
    seconds = {"uniform": [1.0, 1.0, 2.0], "fused": [1.5, 1.6, 3.4]}
    row = {**numbers, "work": {"uniform": 128.0, "fused": 192.0}, "drawing_seconds": seconds}
    line = predicted_table([row]).splitlines()[-1]
    assert line == "| made up | 8 x 4 | 2 | 2.0 | 7812500 | 1.60 [1.50, 1.70] | 1.50 | 0.94 |"
