"""Command ``demo``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the picture and the table.")] = Path("."),
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Render a bundled scene adaptively and uniformly, with as many samples and in as much time, and compare errors.

    Leaves tracer-demo.png and tracer-demo.md in the current folder. Example: tracer demo
    """
    from tracer.io import atomic

    atomic.check_folder(output)
    picture, table = output / "tracer-demo.png", output / "tracer-demo.md"
    for path in (picture, table):
        atomic.check_output(path, overwrite, (path.suffix,))

    from tracer.cli.progress import steps
    from tracer.cli.show import simple_table

    with steps(quiet) as progress:
        progress.begin("Starting Mitsuba")
        from tracer.study.demo import HEADINGS, in_words, run_demo

        progress.begin("Opening the scene")
        lines = run_demo(picture, table, progress)
    if not quiet:
        simple_table(HEADINGS, [line.cells() for line in lines])
        typer.echo(f"{in_words(lines)}\nPicture: {picture}\nTable:   {table}")
