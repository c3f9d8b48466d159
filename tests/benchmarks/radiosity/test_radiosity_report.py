"""The page of results."""

import pytest

from benchmarks.radiosity import ablations as uses
from benchmarks.radiosity import convergence
from benchmarks.radiosity import report as everything
from benchmarks.radiosity import solutions as whole
from benchmarks.radiosity.scenes import examples


@pytest.mark.slow
def test_a_small_report_has_all_its_files_and_can_be_stopped(tmp_path, monkeypatch):
    monkeypatch.setattr(convergence, "RAYS", (64, 256))
    monkeypatch.setattr(everything, "RAYS", (64, 256))
    monkeypatch.setattr(convergence, "SEEDS", 2)
    monkeypatch.setattr(convergence, "TRUTH", 256)
    monkeypatch.setattr(uses, "RAYS", 32)
    monkeypatch.setattr(uses, "SEEDS", 2)
    monkeypatch.setattr(whole, "SPP", 1)
    monkeypatch.setattr(whole, "SEEDS", 2)
    monkeypatch.setattr(whole, "RAYS", 16)
    monkeypatch.setattr(whole, "SIZES", (0.8,))
    monkeypatch.setattr(everything, "examples", lambda: [each for each in examples() if each.name in everything.NEEDED])
    with pytest.raises(KeyboardInterrupt):
        everything.everything(tmp_path, lambda text, done, total: False)
    assert not list(tmp_path.iterdir())
    everything.everything(tmp_path, lambda text, done, total: True)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(everything.FILES)
    page = (tmp_path / "results.md").read_text()
    assert "| deviation, warp |" in page
    assert "Many patches" in page
