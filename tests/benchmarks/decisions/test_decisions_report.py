"""The figures of decisions, with everything made small."""

import json

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.decisions import figures, report
from benchmarks.decisions.figures import Panel
from tracer.io.images import read_picture


def test_a_map_of_samples_has_powers_of_two_below_it():
    axes = Figure().subplots()
    figures.draw(axes, Panel("samples", np.array([[8, 16], [32, 64]]), is_logarithmic=True))
    (bar,) = axes.child_axes
    assert bar.get_xlim() == pytest.approx((8, 64))
    assert [tick for tick in bar.get_xticks() if tick < 65] == [8, 16, 32, 64]


def test_both_maps_of_errors_end_at_the_same_value():
    axes = Figure().subplots(1, 2)
    for axis, largest in zip(axes, (1.0, 0.1), strict=True):
        figures.draw(axis, Panel("error", np.linspace(0, largest, 12).reshape(3, 4), top=0.7))
    assert [axis.images[0].get_clim() for axis in axes] == [(0, 0.7), (0, 0.7)]


@pytest.mark.slow
def test_figures_numbers_and_page_are_written(tmp_path, monkeypatch):
    for name, value in {"SIZE": 96, "REFERENCE_SPP": 64}.items():
        monkeypatch.setattr(report, name, value)
    said = []
    report.report(tmp_path, lambda *step: said.append(step))
    assert [done for _, done, _ in said] == list(range(report.STEPS))
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(report.FILES)
    numbers = json.loads((tmp_path / "results.json").read_text())
    assert numbers["lights"]["same chance"] > numbers["lights"]["learned"] > 0
    assert report.to_page(numbers) == (tmp_path / "results.md").read_text()
    assert read_picture(tmp_path / "decisions.png").shape[1] > read_picture(tmp_path / "lights.png").shape[1]
