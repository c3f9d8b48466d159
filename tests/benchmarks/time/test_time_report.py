"""The report is written, from pictures that are small here."""

import json

import pytest

from benchmarks import harness
from benchmarks.time import measure, report


@pytest.mark.slow
def test_a_report_is_written(tmp_path, monkeypatch):
    public = tmp_path / "public" / "made"
    public.mkdir(parents=True)
    report.write_scene(public / "scene.xml", 5)
    for name, value in (
        ("SHAPES", 12),
        ("WIDTH", 32),
        ("SPPS", (16, 64)),
        ("MORE_SPPS", (4,)),
        ("SIZES", ((48, 27),)),
        ("SCALED_SIZE", (48, 27)),
        ("TURNS", 2),
    ):
        monkeypatch.setattr(measure if name == "TURNS" else report, name, value)
    bundled = [path for path in harness.bundled_scenes() if path.stem == "even_noise"]
    monkeypatch.setattr(harness, "bundled_scenes", lambda: bundled)
    monkeypatch.setattr(report, "SIZED", (report.MADE,))
    steps = []
    report.report(tmp_path, lambda text, done, total: steps.append((done, total)), tmp_path / "public")
    assert steps[-1][0] == steps[-1][1] - 1
    numbers = json.loads((tmp_path / "results.json").read_text())
    ways = {row["way"] for row in numbers["rows"]}
    assert ways == {"multijitter", "independent", "owen_sobol", "uniform", "fused"}
    assert all(len(row["cpu"]) == 2 for row in numbers["rows"] if row["way"] != "fused")
    text = (tmp_path / "results.md").read_text()
    assert "nan" not in text
    assert "| made | 7 |" in text
