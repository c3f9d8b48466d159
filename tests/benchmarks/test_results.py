"""The pages in results/ show the numbers beside them, in the form that the benchmarks write."""

import importlib
import json
import re
from pathlib import Path

import pytest

from benchmarks import harness
from benchmarks.__main__ import ABOUT

RESULTS = Path(__file__).parents[2] / "results"


@pytest.mark.parametrize("path", sorted(RESULTS.glob("**/*.json")), ids=lambda path: str(path.relative_to(RESULTS)))
def test_every_reader_of_json_can_read_it(path):
    def refuse(constant):
        raise AssertionError(f"{constant} is not JSON")

    json.loads(path.read_text(), parse_constant=refuse)


@pytest.mark.parametrize("name", ABOUT)
def test_a_page_is_what_its_numbers_say(name, monkeypatch):
    report = importlib.import_module(f"benchmarks.{name}.report")
    page = (RESULTS / name / "results.md").read_text()
    machine = re.search(r", on (.* with \d+ threads)", page)
    monkeypatch.setattr(harness, "machine", lambda: machine[1])
    monkeypatch.setattr("platform.machine", lambda: "x86_64")
    assert report.to_page(json.loads((RESULTS / name / "results.json").read_text())) == page
    assert all((RESULTS / name / file).exists() for file in report.FILES)
