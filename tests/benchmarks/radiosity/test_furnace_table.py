"""The furnace of the benchmark."""

import pytest

from benchmarks.radiosity import furnace


def test_a_furnace_is_as_right_as_its_rays_and_too_bright_by_the_rules_of_the_paper(monkeypatch):
    monkeypatch.setattr(furnace, "RAYS", (64, 1024))
    names = []
    rows = {(row["way"], row["rays"]): row for row in furnace.furnace(names.append)}
    assert len(names) == furnace.step_count()
    assert rows["shooting, evenly", 1024]["mean"] < 0.5 * rows["shooting, evenly", 64]["mean"]
    assert rows["shooting, evenly", 1024]["all"] == pytest.approx(0, abs=1e-4)
    assert rows["shooting, paper", 1024]["all"] > 0.03
    assert abs(rows["shooting, paper_right", 1024]["all"]) < 0.01
    assert all(row["mean"] <= row["most"] for row in rows.values())
