"""Tables on the terminal."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from tracer.study.clock import clock_warning
from tracer.study.results import Results
from tracer.study.tables import CLOSE_MARK, HEADINGS, bounds, cells, measured

SHOWN = ("method", "relMSE", "SSIM", "FLIP", "seconds", "gain, samples", "gain, time")
"""Headings of the columns that the terminal shows; the files have all columns."""

METHOD_WIDTH = 12
"""Characters of a line of a method's name where a table is wider than the terminal."""
WRAPPED = ("picture", "surface", "material")
"""Headings of columns of names, which may be long."""


def simple_table(headings: Sequence[str], lines: Sequence[Sequence[str]], title: str | None = None) -> None:
    """Print a table without a frame, so that a terminal of 80 columns shows all of a study's table.

    Only gains, methods and names may wrap: gains before their intervals, methods between words.
    """
    console = Console(markup=False)
    table = Table(
        title=title and Text(title),
        title_justify="left",
        box=box.SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    for heading in headings:
        table.add_column(heading, no_wrap=heading not in WRAPPED, overflow="fold")
    for line in narrowed(headings, lines, console.width):
        table.add_row(*(Text(cell) for cell in line))
    console.print(table)
    console.print()


def narrowed(headings: Sequence[str], lines: Sequence[Sequence[str]], width: int) -> list[list[str]]:
    """Return the cells of a table, with line breaks in gains, and then in methods, where it is wider than ``width``."""
    cells_of_lines = [list(line) for line in lines]
    for breaks in (break_gain, break_method):
        if table_width(headings, cells_of_lines) <= width:
            break
        cells_of_lines = [
            [breaks(heading, cell) for heading, cell in zip(headings, line, strict=True)] for line in cells_of_lines
        ]
    return cells_of_lines


def table_width(headings: Sequence[str], lines: Sequence[Sequence[str]]) -> int:
    """Return the characters that a table is wide, with two between columns."""
    columns = zip(headings, *lines, strict=True)
    return sum(2 + max(len(part) for cell in column for part in cell.split("\n")) for column in columns) - 2


def break_gain(heading: str, cell: str) -> str:
    """Return the cell with its interval in a line of its own, if it is a gain."""
    return cell.replace(" [", "\n[", 1) if heading.startswith("gain") else cell


def break_method(heading: str, cell: str) -> str:
    """Return the cell with a line for every few words, if it is a method."""
    return "\n".join(textwrap.wrap(cell, METHOD_WIDTH)) if heading == "method" else cell


def study_tables(results: Results) -> None:
    """Print a table for each scene and budget, the means over scenes if there is more than one, and all failures."""
    rows, means = results.tables()
    columns = [HEADINGS.index(name) for name in SHOWN]
    for (scene, budget), group in itertools.groupby(rows, key=lambda row: (row.scene, row.budget)):
        lines = [[cells(row)[column] for column in columns] for row in group]
        simple_table(SHOWN, lines, f"{scene}, {budget}")
    baseline = results.plan.compared_with
    console = Console(markup=False)
    error = measured(results.plan)
    console.print(f"gain: {error} of {baseline} over that of the method, with its 95 % interval over seeds")
    if any(row.too_close for row in rows):
        console.print(f"{CLOSE_MARK} less than ten times the error of the reference; a larger reference_spp helps")
    if len({row.scene for row in rows}) > 1:
        lines = [
            [mean.budget, mean.method, bounds(mean.gain_samples), bounds(mean.gain_time), f"{mean.worst:.2f}"]
            for mean in means
            if mean.method != baseline
        ]
        headings = ("budget", "method", "gain, samples", "gain, time", "worst")
        simple_table(headings, lines, "geometric mean over scenes")
    if (warning := clock_warning(results)) is not None:
        console.print(warning)
    if results.kept:
        console.print(f"{results.kept} pictures were kept from an earlier run")
    for failure in results.failures:
        console.print(
            f"failed: {failure.scene}, {failure.method}, {failure.budget}, seed {failure.seed}: {failure.message}"
        )
