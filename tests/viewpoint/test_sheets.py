"""Sheets of pictures: whatever their number, pages that fit a screen, and captions as large as they are said to be."""

import numpy as np
import pytest
from PIL import Image

from tracer.viewpoint import sheets
from tracer.viewpoint.sheets import Layout, lay_out, write_sheet


def test_pictures_are_as_large_as_pages_allow():
    assert lay_out(1, 2) == Layout(1, 1, 480)
    assert lay_out(3, 2) == Layout(3, 1, 480)
    assert lay_out(8, 2) == Layout(4, 2, 390)
    assert lay_out(32, 2) == Layout(8, 4, 190)
    assert lay_out(77, 2).capacity == 32
    assert lay_out(132, 2, columns=6) == Layout(6, 4, 206)


@pytest.mark.parametrize("columns", [None, 6])
@pytest.mark.parametrize("count", [1, 2, 5, 7, 12, 13, 20, 31, 33, 162])
def test_every_page_fits(count, columns):
    layout = lay_out(count, 2, columns)
    assert layout.size >= sheets.SMALLEST
    assert layout.columns * (layout.size + sheets.GAP) <= sheets.WIDTH
    assert layout.rows * (layout.size + sheets.GAP + 2 * sheets.LINE) <= sheets.HEIGHT
    assert layout.capacity >= min(count, 24)


def test_pages_hold_the_pictures_pixel_by_pixel_below_their_captions(tmp_path):
    layout = Layout(2, 2, 200)
    generator = np.random.default_rng(0)
    pictures = list(generator.integers(1, 250, (5, 200, 200, 3)) / 255)
    stale = tmp_path / "sheet-3.png"
    stale.touch()
    (tmp_path / "sheet-4.png").touch()
    pages = write_sheet(tmp_path / "sheet.png", pictures, [f"view {k}\nof all" for k in range(5)], layout)
    assert [page.name for page in pages] == ["sheet.png", "sheet-2.png"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["sheet-2.png", "sheet.png"]
    first, second = (np.array(Image.open(page).convert("RGB"), int) for page in pages)
    assert first.shape == (2 * 244, 2 * 210, 3)
    assert second.shape == (244, 210, 3)
    for k in range(4):
        top, left = k // 2 * 244 + 39, k % 2 * 210 + 5
        assert np.abs(first[top : top + 200, left : left + 200] - np.rint(pictures[k] * 255)).max() <= 1
        caption = first[top - 34 : top, left : left + 200].min(axis=(1, 2)) < 128
        heights = np.flatnonzero(np.diff(np.concatenate([[0], caption, [0]])))
        letters = heights[1::2] - heights[::2]
        assert len(letters) == 2  # two lines, apart
        assert min(letters) >= 9  # ascenders of letters 12 pixels high, "f" and "l"
