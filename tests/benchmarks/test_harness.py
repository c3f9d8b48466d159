"""What all benchmarks share: steps, ratios, pages, figures and files."""

import json

import numpy as np
import pytest
from PIL import Image

from benchmarks import harness


def test_steps_are_counted_until_one_is_refused():
    told = []

    def progress(name, done, total):
        told.append((name, done, total))
        return name != "last"

    announce = harness.StepCounter(progress, 3)
    announce("first")
    announce("second")
    with pytest.raises(KeyboardInterrupt):
        announce("last")
    assert told == [("first", 0, 3), ("second", 1, 3), ("last", 2, 3)]


def test_a_progress_that_says_nothing_goes_on():
    harness.StepCounter(lambda *_: None, 1)("first")


def test_ratio_of_errors_that_are_half():
    ratio = harness.ratio_over_seeds([1.0, 2.0, 3.0], [2.0, 4.0, 6.0])
    assert (ratio.mean, ratio.low, ratio.high) == pytest.approx((2, 2, 2))
    ratio = harness.ratio_over_seeds([1.0, 1.0, 1.0], [1.0, 2.0, 4.0])
    # Student: 4.303 standard errors of the logarithm for three seeds.
    reach = 4.303 * np.log(2) / np.sqrt(3)
    assert (ratio.mean, ratio.low, ratio.high) == pytest.approx((2, 2 / np.exp(reach), 2 * np.exp(reach)), rel=1e-3)


def test_a_range_is_of_all_values():
    assert harness.middle_and_range(1.0, [0.5, 1.0, 2.25]) == "1.00 [0.50, 2.25]"


def test_sections_of_a_page_are_apart_however_they_end():
    page = harness.page("Title", "\nWhat it is.", {"First": "| a |\n|---|\n", "Second": "\ntext"})
    assert page == "# Title\n\nWhat it is.\n\n## First\n\n| a |\n|---|\n\n## Second\n\ntext\n"
    assert harness.page("Title", "", {"First": "text"}) == "# Title\n\n## First\n\ntext\n"


def test_results_are_written_as_numbers_and_as_a_page(tmp_path):
    harness.write(tmp_path, {"gain": 1.5}, "# Title\n")
    assert json.loads((tmp_path / "results.json").read_text()) == {"gain": 1.5}
    assert (tmp_path / "results.md").read_text() == "# Title\n"


def test_what_is_no_number_is_written_as_null(tmp_path):
    harness.write(tmp_path, {"gain": [(1.0, float("nan"), float("inf"))]}, "")
    assert json.loads((tmp_path / "results.json").read_text()) == {"gain": [[1.0, None, None]]}


def test_a_figure_is_written_whole_or_not_at_all(tmp_path):
    with harness.figure(tmp_path / "good.png", 2, 1, dpi=50) as figure:
        figure.subplots().plot([0, 1], [0, 1])
    with Image.open(tmp_path / "good.png") as picture:
        assert picture.size == (100, 50)
    with pytest.raises(ZeroDivisionError), harness.figure(tmp_path / "bad.png", 2, 1):
        raise ZeroDivisionError
    assert [path.name for path in tmp_path.iterdir()] == ["good.png"]
