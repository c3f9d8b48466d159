"""Errors of samplers: the variance between seeds is the mean squared error, and ours is small."""

from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from tracer.scene import open_scene
from tracer.source import load
from tracer.study.compare import stock_method
from tracer.study.samplers import Error, markdown, measure, measure_method, ratios


def test_ratios_by_scene():
    errors = [
        Error("a", "owen_sobol", 16, 1.0),
        Error("b", "owen_sobol", 16, 1.0),
        Error("a", "independent", 16, 2.0),
        Error("b", "independent", 16, 8.0),
        Error("a", "multijitter", 16, 1.0),
        Error("b", "multijitter", 16, 1.0),
    ]
    assert ratios(errors, "independent", 16) == [0.5, 0.125]
    assert "| **geometric mean** | **0.25" in markdown(errors)


def test_variance_between_seeds_is_the_error_against_a_reference(cornell):
    scene = cornell((32, 24))
    with open_scene(load(scene, sampler="independent")) as view:
        method = stock_method(view)
        reference = np.mean([method(1024, 100 + seed)[0] for seed in range(4)], axis=0)
        expected = np.mean([(method(16, seed)[0] - reference) ** 2 for seed in range(8)])
        found = measure_method("box", "independent", method, 16, range(8), view.pixel_count)
    assert found.mse == pytest.approx(expected, rel=0.15)


@pytest.mark.slow
def test_error_beside_mitsubas_samplers():
    """MSE of uniform pictures of our scenes: near multijitter's, about half of independent's."""
    scenes = sorted(Path(str(files("tracer.scenes"))).glob("*.xml"))
    assert len(scenes) == 8
    errors = [error for path in scenes for error in measure(path, 256, [16, 64], 2)]

    def mean(other: str, spp: int) -> float:
        return float(np.exp(np.mean(np.log(ratios(errors, other, spp)))))

    for spp in (16, 64):
        assert mean("multijitter", spp) <= 1.15
    assert mean("independent", 64) <= 0.5
    assert mean("independent", 16) <= 0.6
