"""The page of the paper's rules."""

import json
from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.paper import few_rays, figures, methods, report, scenes, shot
from benchmarks.radiosity import convergence
from benchmarks.radiosity.scenes import examples


@pytest.mark.slow
def test_a_small_report_has_all_its_files_and_can_be_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(convergence, "TRUTH", 256)
    monkeypatch.setattr(methods, "SEEDS", 2)
    monkeypatch.setattr(methods, "DEPTHS", (1,))
    forms = [methods.Published(1, False, False), methods.Published(1, True, True)]
    monkeypatch.setattr(methods, "FORMS", forms)
    monkeypatch.setattr(shot, "RAYS", (128,))
    monkeypatch.setattr(shot, "SEEDS", 2)
    monkeypatch.setattr(shot, "TRUTH", 256)
    monkeypatch.setattr(few_rays, "OTHER_LOOKS", few_rays.OTHER_LOOKS[:2])
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
    assert "| as printed, entropy, depth 1, known |" in page
    assert "| as printed, depth 1, 128 rays |" in page
    numbers = json.loads((tmp_path / "results.json").read_text())
    (tmp_path / report.FREE_FIGURE).unlink()
    del numbers["few_rays"]
    (tmp_path / "results.json").write_text(json.dumps(numbers))
    steps.clear()
    report.report(tmp_path, lambda text, done, total: steps.append(text), resume=True)
    # The rest is kept.
    assert [text for text in steps if report.SHOWN in text] == [
        f"{report.SHOWN}, {what}" for what in ("truth", report.FREE_FIGURE, report.COUNTED_FIGURE)
    ]
    assert not [text for text in steps if "shooting" in text]
    assert json.loads((tmp_path / "results.json").read_text())["rows"] == numbers["rows"]
    assert (tmp_path / report.FREE_FIGURE).exists()


def test_depths_stand_in_order_whatever_was_measured_where():
    """The deepest is measured in the second scene alone."""
    depths = {"first": (1, 2), "second": (1, 2, 3)}
    rows = [
        {"scene": scene, "rays": 64, "method": form.name, "gain": [0.5, 0.4, 0.6], "bias": 0.1}
        for scene, measured in depths.items()
        for form in reversed(methods.FORMS)
        if form.depth in measured
    ]
    lines = [line.split("|")[1].strip() for line in report.table(rows).splitlines()[2:]]
    assert lines == [form.name for form in methods.FORMS if form.depth <= 3]
    assert "| as printed, depth 3 | - | 0.50 (+10.0 %) |" in report.table(rows)


def test_gains_are_drawn_by_depth(tmp_path):
    rows = [
        {"scene": "a", "rays": rays, "method": name, "gain": [0.5, 0.4, 0.6]}
        for rays in (64, 256)
        for name in report.ORDER
    ]
    axis = Figure().subplots()
    figures.draw_gains(axis, {row["method"]: row["gain"][0] for row in rows})
    lines = {line.get_label(): line.get_xdata() for line in axis.get_lines()}
    assert {name: list(depths) for name, depths in lines.items() if len(depths) > 2} == {
        name: [1, 2, 3, 4]
        for name in ("as printed", "as printed, looks free", "energies made right", "energies made right, looks free")
    }
    figures.draw_depths(rows, tmp_path / "depths.png")
    assert (tmp_path / "depths.png").stat().st_size > 10_000


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
