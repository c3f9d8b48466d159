"""The report is written, from measurements that are small here."""

import json

import pytest

from benchmarks.cluster import measure
from benchmarks.cluster import report as everything


@pytest.mark.slow
def test_a_report_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(measure, "SIZE", (48, 48))
    monkeypatch.setattr(measure, "SPP", 16)
    monkeypatch.setattr(measure, "SEEDS", (0,))
    monkeypatch.setattr(everything, "SCENES", ("even_noise",))
    seen = []
    everything.everything(tmp_path, lambda text, done, total: seen.append((done, total)))
    assert seen[-1] == (3, 4)
    (pair,) = json.loads((tmp_path / "results.json").read_text())["pairs"]
    assert pair["differing"] == 0
    assert pair["traffic"][0]["bytes_of_sums"] == 460 * 48 * 48
    text = (tmp_path / "results.md").read_text()
    assert "| even_noise |" in text
    assert "nan" not in text
    assert (tmp_path / "scaling.png").stat().st_size > 10000
