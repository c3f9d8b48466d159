"""A metric of one's own stands beside those of a study."""

import csv
import json

import numpy as np
import pytest

from conftest import LIT
from tracer.errors import SettingsError
from tracer.study import cells
from tracer.study.own_metrics import TAKEN, values_of
from tracer.study.plan import make_plan, parse_plan
from tracer.study.run import run_study
from tracer.study.toml_location import Origin


@pytest.fixture
def plan(scene_file):
    scene = scene_file(LIT + '<shape type="sphere"><point name="center" x="0" y="0" z="4"/></shape>', "ball.xml")
    methods = [{"name": "uniform", "criterion": "uniform"}]
    values = {"name": "small", "spp": [2], "seeds": 2, "methods": methods, "reference_spp": 64}
    return make_plan({**values, "scenes": [{"path": str(scene)}]})


def test_a_metric_is_computed_and_written(plan, tmp_path):
    references = []

    def worst(picture, reference):
        references.append(reference)
        return np.abs(picture - reference).max()

    results = run_study(plan, tmp_path / "out", metrics={"worst": worst})
    expected = [
        np.abs(cells.load(entry.cell, tmp_path / "out")[0].image - references[0]).max()
        for entry in results.measurements
    ]
    assert [entry.own["worst"] for entry in results.measurements] == pytest.approx(expected, rel=1e-6)
    assert results.tables()[0][0].own["worst"] == pytest.approx(np.mean(expected), rel=1e-6)
    with (tmp_path / "out" / "results.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert [float(line["worst"]) for line in lines] == pytest.approx(expected, rel=1e-6)
    assert set(lines[0]) - {"worst"} == TAKEN  # no metric can have the name of another column
    written = json.loads((tmp_path / "out" / "results.json").read_text())
    assert written["rows"][0]["own"]["worst"] == pytest.approx(np.mean(expected), rel=1e-6)
    assert f"| ball | 2 spp | uniform | {np.mean(expected):.4g} |" in (tmp_path / "out" / "results.md").read_text()
    again = run_study(plan, tmp_path / "out", metrics={"mean": lambda picture, reference: picture.mean()})
    assert (again.kept, list(again.measurements[0].own)) == (2, ["mean"])
    assert "Own metrics" not in (run_study(plan, tmp_path / "out") and (tmp_path / "out" / "results.md").read_text())


def test_a_metric_that_fails_is_named(plan, tmp_path):
    results = run_study(plan, tmp_path / "out", metrics={"broken": lambda picture, reference: 1 / 0})
    assert "The metric 'broken' failed: ZeroDivisionError: division by zero." in results.failures[0].message


@pytest.mark.parametrize(
    ("name", "metric", "message"),
    [
        ("psnr", max, "'psnr' is the name of another column; choose another name"),
        ("seconds", max, "another column"),
        ("a|b", max, "no name of letters"),
        ("mine", 3, r"'mine' must be a function of picture and reference \(was 3\)"),
    ],
)
def test_what_is_no_metric_is_refused_before_the_first_ray(plan, tmp_path, name, metric, message):
    with pytest.raises(SettingsError, match=message):
        run_study(plan, tmp_path / "out", metrics={name: metric})
    assert not (tmp_path / "out").exists()


def test_a_plan_names_files_with_metrics(tmp_path, scene_file):
    scene = scene_file(LIT + '<shape type="sphere"><point name="center" x="0" y="0" z="4"/></shape>', "ball.xml")
    text = (
        'name = "small"\nspp = [2]\nseeds = 1\nreference_spp = 64\nmetrics = ["mine.py"]\n[[scenes]]\n'
        f'path = "{scene}"\n[[methods]]\nname = "uniform"\ncriterion = "uniform"\n'
    )
    (tmp_path / "mine.py").write_text(
        "from math import exp\nimport numpy as np\nfrom statistics import fmean\n"
        "def _both(picture, reference): return picture.max(), reference.max()\n"
        "def brighter(picture, reference): return np.subtract(*_both(picture, reference))\n"
    )
    plan = parse_plan(text, Origin("mine.toml", text), tmp_path, None)
    (measured,) = run_study(plan, tmp_path / "out", metrics={"one": lambda picture, reference: 1}).measurements
    assert set(measured.own) == {"brighter", "one"}  # and not fmean, which the file has from elsewhere
    mistakes = [
        ("", "mine.toml, line 5: .*mine.py' has no function"),
        ("def psnr(picture, reference): pass", "mine.toml, line 5: .*'psnr' is the name of another column"),
        ("x = 1\ny = 1 / 0", "mine.toml, line 5: .*mine.py', line 2: ZeroDivisionError"),
    ]
    for code, message in mistakes:
        (tmp_path / "mine.py").write_text(code)
        with pytest.raises(SettingsError, match=message):
            run_study(plan, tmp_path / "other")
    (tmp_path / "mine.py").unlink()
    with pytest.raises(SettingsError, match=r"mine.toml, line 5: There is no file '.*mine.py'"):
        run_study(plan, tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_grey_pictures_reach_a_metric_in_colour():
    seen = values_of({"channels": lambda picture, reference: picture.shape[2]}, np.ones((2, 3)), np.zeros((2, 3)))
    assert seen == {"channels": 3.0}
