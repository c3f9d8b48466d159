"""Command ``compare``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options


def compare(
    scenes: Annotated[list[Path], typer.Argument(help="Mitsuba scene files (XML).", show_default=False)],
    spp: Annotated[list[int] | None, typer.Option(help="Mean samples per pixel; several may follow. [64]")] = None,
    seeds: Annotated[int, typer.Option(help="How many seeds.", min=1)] = 5,
    first_seed: Annotated[int, typer.Option(help="The first of them.", min=0)] = 0,
    criterion: Annotated[
        list[str] | None, typer.Option(help="Criteria to compare; several may follow. [fused]")
    ] = None,
    objective: options.Objective = "relative",
    integrator: options.Integrator = None,
    sensor: options.Sensor = 0,
    size: options.Width = None,
    reference_spp: Annotated[int | None, typer.Option(help="Samples per pixel of the reference. [64 x spp]")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Folder for tables and pictures.")] = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure adaptive against uniform sampling and plain mi.render, by a high-spp reference that is kept for later.

    Example: tracer compare scene.xml --spp 16 64
    """
    from tracer import files
    from tracer.cli.show import comparison_table
    from tracer.study.run import Comparison, run_comparison

    comparison = Comparison(
        spps=spp or [64],
        seeds=seeds,
        first_seed=first_seed,
        criteria=criterion or ["fused"],
        objective=objective,
        integrator=integrator,
        sensor=sensor,
        size=size,
        reference_spp=reference_spp,
    )
    comparison.check(scenes)
    if output is not None:
        files.prepare_folder(output, overwrite, comparison.files(scenes))
    from tracer.cli.progress import steps

    with steps(quiet) as progress:
        table = run_comparison(comparison, scenes, output, progress)
    if not quiet:
        comparison_table(table)
