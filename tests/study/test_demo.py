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
        (
            (0.006, 0.003, 0.002),
            ("3.00 times less squared", "1.50 times less in the same time."),
        ),
        (
            (0.006, 0.001, 0.002),
            ("3.00 times less squared", "2.00 times more in the same time."),
        ),
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


@pytest.mark.parametrize(
    ("similarity", "difference", "end"),
    [
        (0.99, 0.01, "in the same time."),
        (0.97, 0.01, "in the same time; by SSIM the uniform picture of the same time is better."),
        (0.97, 0.03, "in the same time; by SSIM and FLIP the uniform picture of the same time is better."),
    ],
)
def test_what_other_metrics_say_against_it_is_said(similarity, difference, end):
    uniform = DemoRow("uniform", Scores(0, 0.006, 0, 0, 0.98, 0.02, 0), 1, 1.0)
    adaptive = DemoRow("fused", Scores(0, 0.002, 0, 0, similarity, difference, 0), 1, 1.0)
    assert in_words([uniform, uniform, adaptive]).endswith(end)


def test_panels_stand_in_rows(tmp_path):
    picture, values = np.zeros((6, 8, 3)), np.ones((6, 8))
    panels = [("a", picture, False), ("b", values, True), ("c", values, False), ("d", picture, False)]
    shapes = {}
    for columns in (None, 2):
        write_panels(tmp_path / "panels.png", panels, "title", 1.0, columns=columns)
        shapes[columns] = read_picture(tmp_path / "panels.png").shape
    assert shapes[None][1] == pytest.approx(2 * shapes[2][1], abs=2)
    assert shapes[2][0] > 1.8 * shapes[None][0] - 100
