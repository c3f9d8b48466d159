"""The benchmark of bias, with everything made small."""

import json

import pytest

from benchmarks.bias import report
from benchmarks.bias.report import Row


def row(**changes):
    methods = ("uniform", "given back", "not given back")
    values = {
        "scene": "a",
        "spp": 16,
        "bias": dict.fromkeys(methods, (0.01, 0.001)),
        "spread": dict.fromkeys(methods, 0.004),
        "gain": dict.fromkeys(methods[1:], (1.5, 1.25, 1.75)),
    }
    return Row(**values | changes)


def test_a_line_has_bias_gain_and_spread():
    bias = "+1.00 ± 0.20"  # 1.96 standard errors
    assert report.cells(row()) == ["a", "16", bias, bias, bias, *["1.50 [1.25, 1.75]"] * 2, "0.40", "0.40"]


@pytest.mark.parametrize("nothing", [float("nan"), None], ids=["measured", "read from a file"])
def test_equal_pictures_have_no_interval(nothing):
    gains = dict.fromkeys(("given back", "not given back"), (1.0, nothing, nothing))
    assert report.cells(row(gain=gains))[5:7] == ["1.00", "1.00"]


@pytest.mark.slow
def test_a_stopped_run_leaves_the_scenes_that_it_has_measured(tmp_path, monkeypatch):
    for name, value in {"SIZE": 8, "BUDGETS": (4,), "SEEDS": 2, "REFERENCE_SPP": 16}.items():
        monkeypatch.setattr(report, name, value)
    said = []

    def until_the_second_scene(text, done, total):
        said.append((text, done, total))
        return done < 3

    with pytest.raises(KeyboardInterrupt):
        report.report(tmp_path, until_the_second_scene)
    assert said[0] == ("cornell_box: reference", 0, 36)  # twelve scenes: a reference, two seeds
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(report.FILES)
    (measured,) = json.loads((tmp_path / "results.json").read_text())
    assert measured["scene"] == "cornell_box"
    assert "| cornell_box | 4 |" in (tmp_path / "results.md").read_text()
