"""Sheets of pictures with captions that can be read on the screen of a laptop, on as many pages as that needs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tracer.core.arrays import Floats
from tracer.viewpoint.plots import figure, save

WIDTH, HEIGHT = 1600, 1000
"""A page has at most this many pixels."""
LETTER, LINE, GAP = 12, 17, 10
"""Pixels: the height of letters, from line to line of a caption, and between pictures."""
SMALLEST, LARGEST = 190, 480
"""Pictures have at least and at most this many pixels along each side."""
DPI = 100
"""Pixels per inch: matplotlib counts in inches, and letters in 1/72 of one."""


@dataclass(frozen=True)
class Layout:
    """How pictures are laid out on pages."""

    columns: int
    rows: int
    size: int
    """Pixels along each side of a picture."""

    @property
    def capacity(self) -> int:
        """How many pictures a page has."""
        return self.columns * self.rows


def lay_out(count: int, lines: int, columns: int | None = None) -> Layout:
    """Return the layout in which ``count`` pictures are largest, with captions of as many ``lines``.

    Pictures that would be smaller than ``SMALLEST`` go on several pages. ``columns``: of a sheet whose rows mean
    something.
    """

    def size_of(across: int, down: int) -> int:
        return min(WIDTH // across - GAP, HEIGHT // down - lines * LINE - GAP, LARGEST)

    most_across, most_down = WIDTH // (SMALLEST + GAP), HEIGHT // (SMALLEST + GAP + lines * LINE)
    choices = [columns] if columns is not None else range(1, min(most_across, max(count, 1)) + 1)
    fitting = [(across, min(-(-max(count, 1) // across), most_down)) for across in choices]
    across, down = max(fitting, key=lambda shape: (min(shape[0] * shape[1], count), size_of(*shape)))
    return Layout(across, down, size_of(across, down))


def pages_of(path: Path, count: int) -> list[Path]:
    """Return the paths of ``count`` pages: ``sheet.png``, ``sheet-2.png``, ..."""
    return [path if k == 0 else path.with_stem(f"{path.stem}-{k + 1}") for k in range(count)]


def remove_later_pages(path: Path, count: int) -> None:
    """Remove the pages that a longer sheet of the same name has left."""
    number = count
    while (later := pages_of(path, number + 1)[-1]).is_file():
        later.unlink()
        number += 1


def write_sheet(path: Path, pictures: Sequence[Floats], captions: Sequence[str], layout: Layout) -> list[Path]:
    """Write pictures (size, size, 3) with captions in a layout, and return the paths of the pages."""
    size, lines = layout.size, max(caption.count("\n") + 1 for caption in captions)
    capacity, cell = layout.capacity, size + GAP
    pages = pages_of(path, -(-len(pictures) // capacity))
    for number, page in enumerate(pages):
        first = number * capacity
        on_page = list(zip(pictures[first : first + capacity], captions[first : first + capacity], strict=True))
        columns = min(layout.columns, len(on_page))
        row_height = cell + lines * LINE
        width, height = columns * cell, -(-len(on_page) // layout.columns) * row_height
        plot = figure(width / DPI, height / DPI, layout=None)
        for k, (picture, caption) in enumerate(on_page):
            left = k % layout.columns * cell + GAP / 2
            top = k // layout.columns * row_height + GAP / 2
            corner = (left / width, 1 - (top + lines * LINE + size) / height)
            axis = plot.add_axes((*corner, size / width, size / height))
            axis.imshow(picture, interpolation="nearest")
            axis.axis("off")
            middle = (left + size / 2) / width
            text_style = {"ha": "center", "va": "top", "fontsize": LETTER * 72 / DPI}
            plot.text(middle, 1 - top / height, caption, linespacing=LINE / LETTER / 1.2, **text_style)
        save(plot, page, DPI)
    remove_later_pages(path, len(pages))
    return pages
