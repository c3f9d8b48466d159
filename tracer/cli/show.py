"""Tables on the terminal."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from tracer.study.results import Results
from tracer.study.tables import CLOSE_MARK, HEADINGS, bounds, cells, measured

SHOWN = ("method", "relMSE", "SSIM", "FLIP", "seconds", "gain, samples", "gain, time")
"""Headings of the columns that the terminal shows; the files have all columns."""


WRAPPED = ("picture", "surface", "material")
"""Headings of columns of names, which may be long."""


def simple_table(headings: Sequence[str], lines: Sequence[Sequence[str]], title: str | None = None) -> None:
    """Print a table without a frame. Only columns of gains and of names may wrap."""
    table = Table(
        title=title and Text(title), title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0)
    )
    for heading in headings:
        is_gain = heading.startswith("gain")
        wraps = is_gain or heading in WRAPPED
        table.add_column(heading, no_wrap=not wraps, min_width=7 if is_gain else None, overflow="fold")
    for line in lines:
        table.add_row(*(Text(cell) for cell in line))
    Console(markup=False).print(table)


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
    if results.kept:
        console.print(f"{results.kept} pictures were kept from an earlier run")
    for failure in results.failures:
        console.print(
            f"failed: {failure.scene}, {failure.method}, {failure.budget}, seed {failure.seed}: {failure.message}"
        )
