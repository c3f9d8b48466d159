"""Logarithmic axes and the frame of a drawing."""

import math
from xml.etree import ElementTree

import pytest

from tracer.study.page.svg import LogAxis, drawing, marker, series, text


def test_places_are_logarithmic_and_stay_within():
    axis = LogAxis(0.1, 10.0, 100, 300)
    assert [axis.place(value) for value in (0.1, 1, 10, 0.01, 100)] == [100, 200, 300, 100, 300]
    assert LogAxis(1, 100, 50, 0).place(10) == 25  # upwards


@pytest.mark.parametrize(("low", "high"), [(0.93, 1.1), (0.5, 3), (0.02, 7), (1e-6, 1e3)])
def test_ticks_are_round_and_enough(low, high):
    ticks = LogAxis(low, high, 0, 100).ticks()
    assert 1 <= len(ticks) <= 14
    assert ticks == sorted(ticks)
    assert all(low <= tick <= high for tick in ticks)
    assert any(math.isclose(tick, 1) for tick in ticks)


def test_what_is_no_positive_number_does_not_count():
    axis = LogAxis.around([0.0, math.inf, math.nan, 2.0, 8.0], 0, 1)
    assert axis.low < 2 < 8 < axis.high < 10
    assert LogAxis.around([], 0, 1).low < 1


def test_a_drawing_is_xml_and_has_an_alternative():
    parts = [text(1, 2, "<a> & b"), *(marker(k, 10 * k, 5) for k in range(9))]
    root = ElementTree.fromstring(drawing(90, 10, 'of "this" & that', parts))
    assert root.get("aria-label") == 'of "this" & that'
    assert root.find("text").text == "<a> & b"
    assert len({path.get("d").partition("m")[2] for path in root.findall("path")[:8]}) == 8
    assert series(9) == "series1"
    assert root.findall("path")[8].get("d").partition("m")[2] != root.findall("path")[0].get("d").partition("m")[2]
