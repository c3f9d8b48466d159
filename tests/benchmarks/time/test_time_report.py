"""The report is written, from pictures that are small here."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks import harness
from benchmarks.time import cases, measure, report
from benchmarks.time.many_shapes import write_scene
from benchmarks.time.ways import in_turn
from tracer.errors import SettingsError


@pytest.mark.slow
def test_a_report_is_written(tmp_path, monkeypatch):
    public = tmp_path / "public" / "made"
    public.mkdir(parents=True)
    write_scene(public / "scene.xml", 5)
    for name, value in (
        ("SHAPES", 12),
        ("WIDTH", 32),
        ("SPPS", (16, 64)),
        ("MORE_SPPS", (4,)),
        ("SIZES", ((48, 27),)),
        ("SCALED_SIZE", (48, 27)),
        ("SIZED", (cases.MADE,)),
        ("TURNS", 2),
    ):
        monkeypatch.setattr(measure if name == "TURNS" else cases, name, value)
    bundled = [path for path in harness.bundled_scenes() if path.stem == "even_noise"]
    monkeypatch.setattr(harness, "bundled_scenes", lambda: bundled)
    steps = []
    report.report(tmp_path, lambda text, done, total: steps.append((done, total)), tmp_path / "public")
    assert steps[-1][0] == steps[-1][1] - 1
    numbers = json.loads((tmp_path / "results.json").read_text())
    rows = [row for case in numbers["cases"].values() for row in case if "parts" in row]
    ways = {row["way"] for row in rows}
    assert ways == {"multijitter", "independent", "owen_sobol", "uniform", "fused"}
    assert all(len(row["cpu"]) == 2 for row in rows if row["way"] != "fused")
    monkeypatch.setattr(report, "measure", lambda case: pytest.fail(f"{case} is measured again"))
    report.report(tmp_path, lambda *now: True, tmp_path / "public", resume=True)
    text = (tmp_path / "results.md").read_text()
    assert not re.search(r"\bnan\b", text)
    assert "| made | 7 |" in text


def test_pictures_that_would_take_too_long_are_left_out(monkeypatch):
    case = cases.Case("slow", Path("slow.xml"), 64, 64, 2)
    first = str(replace(case, spp=cases.SPPS[0]))
    rows = [{"wall": [cases.LONGEST / 2, cases.LONGEST]}] * len(case.ways)
    monkeypatch.setattr(report, "measure", lambda case: pytest.fail("it is rendered"))
    assert report.case_rows(case, {first: rows}) == []
    rendered = []
    monkeypatch.setattr(report, "measure", lambda case: rendered.append(case) or [])
    report.case_rows(case, {})
    report.case_rows(case, {first: rows[:1]})  # a large picture, rendered in one way only
    report.case_rows(case, {first: [{"wall": [cases.LONGEST / 5]}] * len(case.ways)})
    assert len(rendered) == 3


def test_turns_end_when_they_have_taken_long():
    ways = {name: lambda spp, seed: {} for name in "ab"}
    assert [len(times) for times in in_turn(ways, 4, 3, most_seconds=60.0).values()] == [3, 3]
    assert [len(times) for times in in_turn(ways, 4, 3, most_seconds=0.0).values()] == [1, 1]


def test_only_what_this_machine_has_measured_is_gone_on_with(tmp_path):
    path = tmp_path / "results.json"
    for wrong in ("{}", "[]", "{", "3"):
        path.write_text(wrong)
        with pytest.raises(SettingsError, match="is not what this benchmark has left"):
            report.measured_before(path, "A")
    path.write_text(json.dumps({"machine": "B", "cases": {}}))
    with pytest.raises(SettingsError, match="measured on B, not on A"):
        report.measured_before(path, "A")
    assert report.measured_before(path, "B") == {"machine": "B", "cases": {}}
