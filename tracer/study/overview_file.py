"""The overview of a study as a file of its own: ``python -m tracer.study.overview_file FOLDER ...`` writes it again.

A study writes it beside its other results. The command makes it of the ``results.json`` that a folder has, without
measuring anything.
"""

from __future__ import annotations

import json
import re
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

from tracer.errors import OutputError
from tracer.io import atomic
from tracer.study.each_file import exit_code_of_each
from tracer.study.page.overview import LETTER, compared, overviews
from tracer.study.page.svg import drawing, marker, series, text

OVERVIEW = "overview.svg"
"""File name of the overview in the folder of a study."""
GAP, MARGIN, LINE = 24, 12, 20
"""Room between two drawings and around all, and height of a line of the legend."""


def overview(record: dict[str, Any]) -> str | None:
    """Return the overview of the largest budget as the text of an SVG file: at equal samples, and at equal time.

    ``record``: what ``results.json`` has. Returns None if nothing has been measured.
    """
    made = overviews(record)
    if not made:
        return None
    drawings = made[0].drawings
    sizes = [tuple(map(float, re.findall(r"[\d.]+", svg.partition('"')[2].partition('"')[0])[2:])) for svg in drawings]
    width = sum(across for across, _ in sizes) + GAP * (len(sizes) - 1) + 2 * MARGIN
    names, top = legend(record, width)
    parts = [f"<style>{style()}</style>", f'<rect width="{width:g}" height="100%" class="paper"/>', *names]
    left = float(MARGIN)
    for svg, (across, down) in zip(drawings, sizes, strict=True):
        parts.append(svg.replace("<svg", f'<svg x="{left:g}" y="{top:g}" width="{across:g}" height="{down:g}"', 1))
        left += across + GAP
    height = top + max(down for _, down in sizes) + MARGIN
    label = f"What methods gain over {record['baseline']} at {made[0].budget}, scene by scene"
    whole = drawing(width, height, label, parts)
    size = f'width="{width:g}" height="{height:g}"'
    return whole.replace("<svg", f'<svg xmlns="http://www.w3.org/2000/svg" {size}', 1) + "\n"


def legend(record: dict[str, Any], width: float) -> tuple[list[str], float]:
    """Return the markers and names of all methods, in lines of at most ``width``, and where the lines end."""
    parts: list[str] = []
    x, y = float(MARGIN), MARGIN + LINE / 2
    for name, index in compared(record).items():
        across = 34 + LETTER * len(name)
        if x + across > width and x > MARGIN:
            x, y = float(MARGIN), y + LINE
        parts.append(f'<g class="{series(index)}">{marker(index, x + 6, y)}</g>{text(x + 16, y + 4, name, "start")}')
        x += across
    return parts, y + LINE / 2 + 4


def style() -> str:
    """Return the page's rules for drawings, its light colours in place of variables, which some programs lack."""
    page = (files("tracer.study.page") / "style.css").read_text(encoding="utf-8")
    colours = dict(re.findall(r"(--\w+): (#\w+)", page.partition("@media")[0]))
    rules = re.findall(r"(\.(?:plot [.a-z]|series\d )[^{}]*\{[^}]*\})", page)
    lines = [*rules, ".paper { fill: var(--paper); }"]
    return re.sub(r"var\((--\w+)\)", lambda found: colours[found[1]], " ".join(lines))


def write_overview(folder: Path, record: dict[str, Any]) -> None:
    """Write the overview into the folder of a study, if anything has been measured."""
    drawn = overview(record)
    if drawn is not None:
        atomic.write_text(folder / OVERVIEW, drawn)


def main(arguments: list[str]) -> int:
    """Write the overviews of the folders that ``arguments`` name; return an exit code."""
    return exit_code_of_each(arguments, renew_overview)


def renew_overview(folder: Path) -> None:
    """Write the overview of what a folder has. Raises OutputError if that is not from a study."""
    path = folder / "results.json"
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        record["study"]["methods"]
    except (OSError, ValueError, KeyError, TypeError):
        raise OutputError(f"'{path}' is not from a study; name the folder of one.") from None
    write_overview(folder, record)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
