"""Colours of the page can be read in light and in dark: the ratios of WCAG 2.2, sections 1.4.3 and 1.4.11."""

import re
from pathlib import Path

import pytest

import tracer.study.page

STYLE = (Path(tracer.study.page.__file__).parent / "style.css").read_text()
TEXT, GRAPHICS = 4.5, 3.0
DARK = {
    "query": r":root:not\(\[data-theme=\"light\"\]\) \{(.*?)\}",
    "button": r":root\[data-theme=\"dark\"\] \{(.*?)\}",
}


def colours(block):
    return dict(re.findall(r"--(\w+): (#[0-9a-f]{3,6})", block))


def schemes():
    light = colours(re.search(r"^:root \{(.*?)\}", STYLE, re.DOTALL | re.MULTILINE)[1])
    paper = colours(re.search(r":root, :root\[data-theme\] \{(.*?)\}", STYLE, re.DOTALL)[1])
    dark = {name: colours(re.search(pattern, STYLE, re.DOTALL)[1]) for name, pattern in DARK.items()}
    return {"light": light, "print": light | paper, **{name: light | block for name, block in dark.items()}}


def luminance(colour):
    digits = colour[1:] if len(colour) == 7 else "".join(2 * digit for digit in colour[1:])
    channels = [int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(first, second):
    lighter, darker = sorted((luminance(first), luminance(second)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def test_the_ratio_is_that_of_the_standard():
    assert contrast("#000", "#ffffff") == pytest.approx(21)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)  # the grey that just fails


@pytest.mark.parametrize("scheme", ["light", "query", "button", "print"])
def test_text_and_marks_stand_out(scheme):
    names = schemes()[scheme]
    for text in ("ink", "quiet", "good", "bad"):
        for ground in ("paper", "soft"):
            assert contrast(names[text], names[ground]) >= TEXT, (text, ground)
    assert contrast(names["paper"], names["mark"]) >= TEXT  # the button that is pressed
    series = [name for name in names if name.startswith("series")]
    assert len(series) == 8
    for mark in [*series, "mark", "edge"]:
        for ground in ("paper", "soft"):
            assert contrast(names[mark], names[ground]) >= GRAPHICS, (mark, ground)


def test_both_ways_to_dark_are_the_same():
    assert schemes()["query"] == schemes()["button"]
