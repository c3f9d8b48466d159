"""Tables on the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from tracer.study.compare import BASELINE
from tracer.study.table import HEADINGS, Row, bounds, cells, overall


def comparison_table(table: Sequence[Row]) -> None:
    """Print the rows of a comparison, and the means over scenes if there are several."""
    console = Console()
    shown = Table(*HEADINGS, caption="gain: relMSE of uniform over that of the method, 95 % interval over seeds")
    for row in table:
        shown.add_row(*cells(row))
    console.print(shown)
    if len({row.scene for row in table}) > 1:
        means = Table("spp", "method", "gain, samples", "gain, time", title="geometric mean over scenes")
        for spp, method, samples, seconds in overall(table):
            if method != BASELINE:
                means.add_row(str(spp), method, bounds(samples), bounds(seconds))
        console.print(means)
