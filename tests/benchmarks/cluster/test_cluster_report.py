"""The report is written, from measurements that are small here."""

import json

import pytest

from benchmarks.cluster import measure, report


@pytest.mark.slow
def test_a_report_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(measure, "SIZE", (48, 48))
    monkeypatch.setattr(measure, "SPP", 16)
    monkeypatch.setattr(measure, "SEEDS", (0,))
    monkeypatch.setattr(report, "SCENES", ("even_noise",))
    steps = []
    report.report(tmp_path, lambda text, done, total: steps.append((done, total)))
    assert steps[-1] == (3, 4)
    (pair,) = json.loads((tmp_path / "results.json").read_text())["pairs"]
    assert pair["differing"] == 0
    assert pair["traffic"][0]["bytes_of_sums"] == 460 * 48 * 48
    text = (tmp_path / "results.md").read_text()
    assert "| even_noise |" in text
    assert "nan" not in text
    assert (tmp_path / "scaling.png").stat().st_size > 10000
