"""Tables on the terminal."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from tracer.study.compare import BASELINE
from tracer.study.table import HEADINGS, Row, bounds, cells, overall

OWN_COLUMNS = 2
"""Scene and spp head a table of their own instead of being columns."""


def comparison_table(table: Sequence[Row]) -> None:
    """Print a table for each scene and budget, and the means over scenes if there are several."""
    console = Console()
    for (scene, spp), group in itertools.groupby(table, key=lambda row: (row.scene, row.spp)):
        shown = Table(
            title=f"{scene}, {spp} spp", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0)
        )
        for heading in HEADINGS[OWN_COLUMNS:]:
            is_gain = heading.startswith("gain")
            shown.add_column(heading, no_wrap=not is_gain, min_width=7 if is_gain else None)
        for row in group:
            shown.add_row(*cells(row)[OWN_COLUMNS:])
        console.print(shown)
    console.print("gain: relMSE of uniform over that of the method, with its 95 % interval over seeds")
    if len({row.scene for row in table}) > 1:
        means = Table("spp", "method", "gain, samples", "gain, time", title="geometric mean over scenes")
        for spp, method, samples, seconds in overall(table):
            if method != BASELINE:
                means.add_row(str(spp), method, bounds(samples), bounds(seconds))
        console.print(means)
