"""Shooting by the paper's rules, beside random rays."""

import pytest

from benchmarks.paper import shot
from benchmarks.paper.scenes import room
from benchmarks.radiosity.scenes import Example, load


def test_gains_bias_and_rays_of_shooting(monkeypatch):
    monkeypatch.setattr(shot, "RAYS", (96,))
    monkeypatch.setattr(shot, "SEEDS", 2)
    monkeypatch.setattr(shot, "TRUTH", 512)
    monkeypatch.setattr(shot, "RESIDUAL", 0.02)
    monkeypatch.setattr("benchmarks.paper.scenes.THINGS", 10)
    steps = []
    rows = shot.measure(Example("small", "", load(room(lamp=True)), 2.5, True), steps.append)
    assert len(steps) == shot.step_count()
    by_method = {row["method"]: row for row in rows}
    assert list(by_method) == list(shot.WAYS)[1:]
    assert by_method["lattice"]["gain"][0] > 1
    assert by_method["lattice"]["traced"] == pytest.approx(1, abs=0.05)
    assert by_method["as printed, depth 0"]["bias"] > 0.1
    assert abs(by_method["energies right, depth 0"]["bias"]) < 0.05
    assert min(row["traced"] for name, row in by_method.items() if name != "lattice") > 1.05
