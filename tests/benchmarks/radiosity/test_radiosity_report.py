"""The page of results."""

import json
from dataclasses import replace

import pytest

from benchmarks.radiosity import ablations, convergence, furnace, report, solutions, views
from benchmarks.radiosity.scenes import examples


@pytest.mark.slow
def test_a_small_report_has_all_its_files_and_can_be_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(convergence, "RAYS", (64, 256))
    monkeypatch.setattr(convergence, "SEEDS", 2)
    monkeypatch.setattr(convergence, "TRUTH", 256)
    monkeypatch.setattr(ablations, "RAYS", 32)
    monkeypatch.setattr(ablations, "SEEDS", 2)
    monkeypatch.setattr(solutions, "SPP", 1)
    monkeypatch.setattr(solutions, "SEEDS", 2)
    monkeypatch.setattr(solutions, "RAYS", 16)
    monkeypatch.setattr(solutions, "SIZES", (0.8,))
    monkeypatch.setattr(solutions, "PATHS", 64)
    monkeypatch.setattr(views, "SPP", 1)
    monkeypatch.setattr(views, "TURNS", 1)
    monkeypatch.setattr(views, "TRUTH", 4)
    monkeypatch.setattr(furnace, "RAYS", (64,))
    few = [name for name in ablations.USES if name in ("deviation", "entropy", "deviation, depth 0")]
    monkeypatch.setattr(ablations, "USES", {name: ablations.USES[name] for name in few})
    needed = [example for example in examples() if example.name in (report.SOLVED[0], report.CORNELL)]
    coarse = [replace(example, size=2 * example.size) for example in needed]
    monkeypatch.setattr(report, "examples", lambda: coarse)
    with pytest.raises(KeyboardInterrupt):
        report.report(tmp_path, lambda text, done, total: False)
    assert not list(tmp_path.iterdir())
    steps = []
    report.report(tmp_path, lambda text, done, total: steps.append((done, total)))
    assert steps == [(done, len(steps)) for done in range(len(steps))]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(report.FILES)
    page = (tmp_path / "results.md").read_text()
    assert "| deviation, warp |" in page
    assert "Many patches" in page
    numbers = json.loads((tmp_path / "results.json").read_text())
    (tmp_path / "results.json").write_text(json.dumps({name: numbers[name] for name in numbers if name != "views"}))
    steps.clear()
    report.report(tmp_path, lambda text, done, total: steps.append((done, total)), resume=True)
    assert len(steps) == len(numbers["views"])  # nothing else is measured again
    assert set(json.loads((tmp_path / "results.json").read_text())) == set(numbers)
