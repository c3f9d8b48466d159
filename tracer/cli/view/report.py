"""Command ``view report``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options
from tracer.cli.view import common


def report(
    public: Annotated[Path, typer.Argument(help="Folder with the folders meshes and molecules.", show_default=False)],
    output: common.Output,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure and draw all that is claimed of views: rate, searches, convergence, molecules, pictures. Ten minutes.

    Example: tracer view report PUBLIC -o results/viewpoint
    """
    from importlib.resources import as_file, files

    from tracer.cli.progress import steps
    from tracer.core import backend
    from tracer.errors import SceneError
    from tracer.io.atomic import prepare_folder

    for name in ("meshes", "molecules"):
        if not (public / name).is_dir():
            raise SceneError(f"There is no folder '{public / name}'; name the folder that has it.")
    backend.activate()
    from tracer.viewpoint.reports import everything

    prepare_folder(output, overwrite, everything.FILES)
    with steps(quiet) as told, as_file(files("tracer.scenes")) as scenes:
        everything.everything(public, scenes, output, told)
    if not quiet:
        typer.echo(f"{output / 'results.md'} has everything.")
