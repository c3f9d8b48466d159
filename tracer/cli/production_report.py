"""Command ``production-report``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options


def production_report(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write to.")],
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure what is claimed of noise targets, limits of time, live pictures and checkpoints. Half an hour.

    Example: tracer production-report -o results/production
    """
    from tracer.cli.progress import steps
    from tracer.core import backend
    from tracer.io.atomic import prepare_folder

    backend.activate()
    from tracer.study.production import everything

    prepare_folder(output, overwrite, everything.FILES)
    with steps(quiet) as step:
        everything.everything(output, step)
    if not quiet:
        typer.echo(f"{output / 'results.md'} has everything.")
