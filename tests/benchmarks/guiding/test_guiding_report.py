"""The benchmark of guiding, with everything made small."""

import json

import pytest

from benchmarks.guiding import report


def row(scene="a", value=1.5):
    return {"scene": scene, "slots": 3, "factors": {name: [value, value + 1] for name in report.COLUMNS}}


def test_a_line_has_the_mean_of_the_seeds():
    page = report.to_page([row(), row("b", 3.5)])
    assert "| a | 3 | 2.00 | 2.00 | 2.00 | 2.00 | 2.00 | 2.00 |" in page
    assert "| **geometric mean** |  | **2.83** |" in page


@pytest.mark.slow
def test_every_scene_with_paths_has_a_line(tmp_path, monkeypatch):
    for name, value in {"SIZE": 12, "PATHS": 1 << 11, "SEEDS": (1,)}.items():
        monkeypatch.setattr(report, name, value)
    ours = report.openers(tmp_path)
    kept = ("even_noise", "many_lights", "lamp_and_sky")
    monkeypatch.setattr(report, "openers", lambda public: {name: ours[name] for name in kept})
    steps = []
    report.report(tmp_path, lambda *step: steps.append(step), tmp_path)
    assert [step[0] for step in steps] == list(kept)
    rows = json.loads((tmp_path / "results.json").read_text())
    assert [measured["scene"] for measured in rows] == list(kept)
    assert all(min(values) >= 1 for measured in rows for values in measured["factors"].values())
    assert report.to_page(rows) == (tmp_path / "results.md").read_text()
