"""Command ``radiosity-report``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options


def radiosity_report(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write to.")],
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure and draw all that is claimed of radiosity: guided rays, even ones and paths. Half an hour.

    Example: tracer radiosity-report -o results/radiosity
    """
    from tracer.cli.progress import steps
    from tracer.core import backend
    from tracer.io.atomic import prepare_folder

    backend.activate()
    from tracer.radiosity.report import everything

    prepare_folder(output, overwrite, everything.FILES)
    with steps(quiet) as told:
        everything.everything(output, told)
    if not quiet:
        typer.echo(f"{output / 'results.md'} has everything.")
