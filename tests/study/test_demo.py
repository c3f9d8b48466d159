"""The demonstration: as many samples and as much time, said honestly, and shown in one picture."""

from types import SimpleNamespace

import numpy as np
import pytest

from tracer.image.metrics import Scores
from tracer.io.images import read_picture
from tracer.study.demo import DemoRow, in_words, spp_in
from tracer.study.panels import write_panels


def test_uniform_sampling_gets_the_time_of_the_adaptive_picture():
    uniform = SimpleNamespace(samples=np.full((2, 3), 64), seconds=2.0)
    assert spp_in(3.0, uniform) == 96
    assert spp_in(0.0, uniform) == 1


@pytest.mark.parametrize(
    ("errors", "clauses"),
    [
        ((0.006, 0.003, 0.002), ("3.00 times less relMSE with as many", "1.50 times less in the same time.")),
        ((0.006, 0.001, 0.002), ("3.00 times less relMSE with as many", "2.00 times more in the same time.")),
    ],
)
def test_a_loss_is_said_as_well_as_a_gain(errors, clauses):
    lines = [
        DemoRow(name, Scores(0, error, 0, 0, 0, 0, 0), 1, seconds)
        for name, error, seconds in zip(("uniform", "uniform, as long", "fused"), errors, (1.0, 2.0, 2.0), strict=True)
    ]
    sentence = in_words(lines)
    assert all(clause in sentence for clause in clauses)
    assert "(in 2.0 s instead of 1.0 s)" in sentence


def test_panels_stand_in_rows(tmp_path):
    picture, values = np.zeros((6, 8, 3)), np.ones((6, 8))
    panels = [("a", picture, False), ("b", values, True), ("c", values, False), ("d", picture, False)]
    shapes = {}
    for columns in (None, 2):
        write_panels(tmp_path / "panels.png", panels, "title", 1.0, columns=columns)
        shapes[columns] = read_picture(tmp_path / "panels.png").shape
    assert shapes[None][1] == pytest.approx(2 * shapes[2][1], abs=2)
    assert shapes[2][0] > 1.8 * shapes[None][0] - 100
