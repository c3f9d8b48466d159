"""The overview of a study as a file: a picture that stands alone, made of the numbers that a study has stored."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from study.page.conftest import made_up
from tracer.study.overview_file import main, overview
from tracer.study.write import finite, numbers, write_results

RESULTS = Path(__file__).parents[2] / "results"
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def record():
    return numbers(made_up(3, 6)[0])


def test_both_comparisons_stand_beside_one_another_below_the_names(record):
    root = ElementTree.fromstring(overview(record))
    first, second = root.findall(f"{SVG}svg")
    assert [part.get("aria-label").split(",")[0] for part in (first, second)] == [
        "Gain over uniform at equal samples",
        "Gain over uniform at equal time",
    ]
    assert float(first.get("x")) + float(first.get("width")) < float(second.get("x"))
    assert float(second.get("x")) + float(second.get("width")) <= float(root.get("width"))
    assert float(first.get("y")) + float(first.get("height")) <= float(root.get("height"))
    names = [(text.text, float(text.get("y"))) for text in root.findall(f"{SVG}text")]
    assert [name for name, _ in names] == ["fused", "edges", "stock a", "stock b", "stock c"]
    assert max(y for _, y in names) < float(first.get("y"))


def test_no_colour_is_missing(record):
    text = overview(record)
    assert "var(" not in text
    rules = set(re.findall(r"\.(\w+) {", text))
    used = {name for names in re.findall(r' class="([^"]+)"', text) for name in names.split()}
    assert used - {"plot"} <= rules


def test_names_that_do_not_fit_are_in_another_line(record):
    methods = [{"name": f"method with a long name {k}"} for k in range(20)]
    root = ElementTree.fromstring(overview({**record, "study": {"methods": methods}, "baseline": methods[0]["name"]}))
    places = [(float(text.get("x")), float(text.get("y"))) for text in root.findall(f"{SVG}text")]
    assert len({y for _, y in places}) > 2
    assert max(x for x, _ in places) < float(root.get("width")) - 150


def test_a_study_writes_what_the_command_writes_of_its_numbers(tmp_path, record):
    results, _ = made_up(2, 3)
    write_results(tmp_path, results)
    written = (tmp_path / "overview.svg").read_text()
    (tmp_path / "overview.svg").unlink()
    assert main([str(tmp_path)]) == 0
    assert (tmp_path / "overview.svg").read_text() == written


def test_nothing_is_drawn_where_nothing_was_measured(tmp_path):
    results, _ = made_up(1, 2)
    results.measurements, results.scenes = [], []
    write_results(tmp_path, results)
    assert not (tmp_path / "overview.svg").exists()


@pytest.mark.parametrize("text", [None, "{", "[]", "{}"])
def test_a_folder_of_no_study_is_one_sentence(tmp_path, capsys, text):
    if text is not None:
        (tmp_path / "results.json").write_text(text)
    assert main([str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"'{tmp_path / 'results.json'}' is not from a study; name the folder of one.\n"


@pytest.mark.parametrize("path", sorted(RESULTS.glob("*/overview.svg")), ids=lambda path: path.parent.name)
def test_overviews_of_results_are_those_of_their_numbers(path):
    assert path.read_text() == overview(finite(json.loads((path.parent / "results.json").read_text())))
