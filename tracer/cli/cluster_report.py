"""Command ``cluster-report``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options


def cluster_report(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder to write to.")],
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure two workers against one process, what travels, and model more of them. Ten minutes.

    Example: tracer cluster-report -o results/cluster
    """
    from tracer.cli.progress import steps
    from tracer.core import backend
    from tracer.io.atomic import prepare_folder

    backend.activate()
    from tracer.study.cluster import everything

    prepare_folder(output, overwrite, everything.FILES)
    with steps(quiet) as step:
        everything.everything(output, step)
    if not quiet:
        typer.echo(f"{output / 'results.md'} has everything.")
