"""Command ``study``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options


def study(
    name: Annotated[str, typer.Argument(help="overhead or samplers.", show_default=False)],
    scenes: Annotated[list[Path], typer.Argument(help="Mitsuba scene files (XML).", show_default=False)],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the table and all numbers.")],
    spp: Annotated[list[int] | None, typer.Option(help="Samples per pixel; several may follow. [64]")] = None,
    size: Annotated[int | None, typer.Option(help="Width in pixels. [overhead: 512, square; samplers: 256]")] = None,
    seeds: Annotated[int, typer.Option(help="How many seeds, or repetitions of every timing.", min=2)] = 5,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure what our samples are worth and what they cost, beside plain mi.render, over several scenes.

    overhead: seconds of mi.render, of a constant map and of an adaptive one.
    samplers: error of a uniform picture by owen_sobol and by Mitsuba's samplers.

    Example: tracer study overhead scene.xml -o results
    """
    from tracer.study.named import find_study, prepare, run_study

    spps = spp or [64]
    find_study(name, spps)
    prepare(name, scenes, size, output, overwrite)
    from tracer.cli.progress import steps

    with steps(quiet) as progress:
        table = run_study(name, scenes, output, spps, seeds, size, progress)
    if not quiet:
        typer.echo(table)
