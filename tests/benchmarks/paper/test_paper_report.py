"""The page of the paper's rules."""

from dataclasses import replace

import pytest

from benchmarks.paper import methods, report
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
