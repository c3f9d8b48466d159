"""The page of the paper's rules."""

import json
from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from benchmarks.paper import few_rays, methods, report, scenes
from benchmarks.radiosity import convergence
from benchmarks.radiosity.scenes import examples


@pytest.mark.slow
def test_a_small_report_has_all_its_files_and_can_be_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(convergence, "TRUTH", 256)
    monkeypatch.setattr(methods, "SEEDS", 2)
    monkeypatch.setattr(methods, "DEPTHS", (1,))
    forms = [methods.Published(1, False, False), methods.Published(1, True, True)]
    monkeypatch.setattr(methods, "FORMS", forms)
    shown = [replace(example, size=2 * example.size) for example in examples() if example.name == report.SHOWN]
    monkeypatch.setattr(report, "examples", lambda: shown)
    monkeypatch.setattr(few_rays, "SEEDS", 2)
    monkeypatch.setattr(few_rays, "RAYS", (32,))
    monkeypatch.setattr(few_rays, "LOOKS", (few_rays.Looked("depth 1, known", 1, few_rays.KNOWN, True),))
    monkeypatch.setattr(scenes, "THINGS", 20)
    room = next(example for example in scenes.rooms() if example.name == report.ROOM)
    monkeypatch.setattr(report, "rooms", lambda: [replace(room, size=2.0)])
    with pytest.raises(KeyboardInterrupt):
        report.report(tmp_path, lambda text, done, total: False)
    assert not list(tmp_path.iterdir())
    steps = []
    report.report(tmp_path, lambda text, done, total: steps.append((done, total)))
    assert steps == [(done, len(steps)) for done in range(len(steps))]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(report.FILES)
    page = (tmp_path / "results.md").read_text()
    assert "| as printed, depth 1 |" in page
    assert "| energies made right, depth 1, looks free |" in page
    assert "| energies right, depth 1, known |" in page
    numbers = json.loads((tmp_path / "results.json").read_text())
    del numbers["few_rays"]
    (tmp_path / "results.json").write_text(json.dumps(numbers))
    steps.clear()
    report.report(tmp_path, lambda text, done, total: steps.append(text), resume=True)
    assert {text.partition(",")[0] for text in steps} == {report.ROOM}  # the rest is kept
    assert json.loads((tmp_path / "results.json").read_text())["rows"] == numbers["rows"]


def test_uniform_rays_are_right_on_average():
    """Under an even sky of radiance 1, irradiance is pi; uniform rays have the variance of 2 cos: a third of pi^2."""
    points, rays = 2000, 16
    point = dr.repeat(dr.arange(mi.UInt32, points), rays)
    local, weight = few_rays.uniformly(
        point, dr.tile(dr.arange(mi.UInt32, rays), points), dr.opaque(mi.UInt32, rays), 0
    )
    irradiance = np.array(weight).reshape(points, rays).sum(axis=1)
    assert np.array(local.z).min() >= 0
    error = np.pi / np.sqrt(3 * points * rays)
    assert irradiance.mean() == pytest.approx(np.pi, abs=4 * error)
    assert irradiance.var() * rays == pytest.approx(np.pi**2 / 3, rel=0.15)
