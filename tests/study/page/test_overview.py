"""The overview shows every gain at its place."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from study.page.conftest import made_up
from tracer.study.page.overview import MEAN, overviews
from tracer.study.tables import bounds
from tracer.study.write import numbers


@pytest.fixture(scope="module")
def results():
    return made_up(3, 3)[0]


def notes(drawing):
    return [title.text for title in ElementTree.fromstring(drawing).iter("title")]


def test_every_budget_has_both_comparisons(results):
    made = overviews(numbers(results))
    assert [overview.budget for overview in made] == ["64 spp", "16 spp"]
    samples, time = made[0].drawings
    assert ElementTree.fromstring(samples).get("aria-label").startswith("Gain over uniform at equal samples, 64 spp")
    assert ElementTree.fromstring(time).get("aria-label").startswith("Gain over uniform at equal time, 64 spp")


def test_every_gain_is_there_with_its_numbers(results):
    rows, means = results.tables()
    expected = [
        f"{row.scene}, {row.method}: {bounds(row.gain_time)}"
        for row in rows
        if row.budget == "64 spp" and row.method != "uniform"
    ]
    expected += [f"{MEAN}, {mean.method}: {bounds(mean.gain_time)}" for mean in means if mean.budget == "64 spp"]
    assert sorted(notes(overviews(numbers(results))[0].drawings[1])) == sorted(
        note for note in expected if ", uniform:" not in note
    )


def test_dots_are_right_of_one_where_the_gain_is_above_one(results):
    root = ElementTree.fromstring(overviews(numbers(results))[0].drawings[0])
    one = float(next(line.get("x1") for line in root.iter("line") if line.get("class") == "one"))
    for group in root.findall("g"):
        x = float(re.match(r"M([\d.]+)", group.find("path").get("d"))[1])
        gain = float(group.find("title").text.rpartition(": ")[2].split()[0])
        assert (x > one) == (gain > 1)
        stroke = group.find("line")
        if stroke is not None:
            assert float(stroke.get("x1")) <= x <= float(stroke.get("x2"))
    assert "1" in [text.text for text in root.iter("text") if text.get("class") == "strong"]


def test_long_names_are_cut():
    results = made_up(1, 2)[0]
    results.scenes[0] = replace(results.scenes[0], name="s" * 60)
    results.measurements = [replace(entry, cell=replace(entry.cell, scene="s" * 60)) for entry in results.measurements]
    root = ElementTree.fromstring(overviews(numbers(results))[0].drawings[0])
    assert max(len(text.text) for text in root.iter("text") if text.text.startswith("sss")) == 24
