"""The report of production features: what its tables say, and that it can be made."""

import json

import pytest

from benchmarks import harness
from benchmarks.production import noise_targets, overhead, report
from benchmarks.production.noise_targets import Stop


def stop(**changes):
    values = {"scene": "a", "criterion": "fused", "target": 0.1, "seed": 0, "stopped_by": "noise"}
    return Stop(**{**values, "predicted": 0.1, "true": 0.1, "within": 0.95, "spp": 10.0, "seconds": 1.0} | changes)


def test_ratios_beyond_the_factor_are_marked():
    assert noise_targets.ratio([]) == "-"
    assert noise_targets.ratio([stop(predicted=0.11), stop(predicted=0.09)]) == "0.99 [0.90, 1.10]"
    assert noise_targets.ratio([stop(predicted=0.2)]) == "**2.00 [2.00, 2.00]**"
    assert noise_targets.ratio([stop(true=0.2)]).startswith("**0.50")


def test_a_budget_that_came_first_is_marked():
    assert noise_targets.amount([stop(), stop(spp=20.0)]) == "15"
    assert noise_targets.amount([stop(), stop(spp=20.0, stopped_by="spp")]) == ">15"


@pytest.mark.slow
def test_everything_is_measured_and_written(tmp_path, monkeypatch):
    monkeypatch.setattr(noise_targets, "TARGETS", (0.5, 0.2))
    monkeypatch.setattr(noise_targets, "SEEDS", (0,))
    monkeypatch.setattr(noise_targets, "WIDTH", 24)
    monkeypatch.setattr(noise_targets, "MOST_SPP", 32)
    monkeypatch.setattr(noise_targets, "REFERENCE_SPP", 64)
    monkeypatch.setattr(overhead, "WIDTH", 24)
    monkeypatch.setattr(overhead, "WANTED_SECONDS", 0.1)
    monkeypatch.setattr(overhead, "REPEATS", 1)
    monkeypatch.setattr(overhead, "LIMITS", (1.0,))
    interior = [path for path in harness.bundled_scenes() if path.stem == "window_interior"]
    monkeypatch.setattr(harness, "bundled_scenes", lambda: interior)
    folder = tmp_path / "out"
    folder.mkdir()
    said = []
    report.report(folder, lambda text, done, total: said.append((text, done, total)))
    assert sorted(path.name for path in folder.iterdir()) == sorted(report.FILES)
    found = json.loads((folder / "results.json").read_text())
    assert len(found["noise"]) == 4
    assert {row["way"] for row in found["costs"]} == {"plain", "live", "checkpoint"}
    assert found["limits"][0]["seconds"] > 1
    assert all(done < total for _, done, total in said)
    assert "window_interior" in (folder / "results.md").read_text()


def test_it_can_be_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(overhead, "WIDTH", 16)
    with pytest.raises(KeyboardInterrupt):
        report.report(tmp_path, lambda text, done, total: False)
