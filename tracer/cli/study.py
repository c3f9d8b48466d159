"""Command ``study``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tracer.cli import options

STUDIES = ("overhead", "samplers")


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
    from tracer import backend, files
    from tracer.errors import SettingsError
    from tracer.settings import known, make_settings
    from tracer.study import overhead, samplers
    from tracer.study.record import record_files, write_record
    from tracer.study.run import check_names, check_scenes

    try:
        known(name, "study", list(STUDIES))
    except ValueError as error:
        raise SettingsError(f"{error}.") from None
    spps = [make_settings(spp=each).spp for each in spp or [64]]
    if name == "overhead" and len(spps) > 1:
        raise SettingsError(f"The study 'overhead' takes one --spp (was {', '.join(map(str, spps))}).")
    backend.activate()
    check_names(scenes)
    check_scenes(scenes, size)
    files.prepare_folder(output, overwrite, record_files(name))
    from tracer.cli.progress import steps

    with steps(quiet) as progress:
        if name == "overhead":
            timings = overhead.measure_overhead(scenes, size or 512, spps[0], seeds, progress)
            table, numbers = overhead.markdown(timings), overhead.numbers(timings)
            side = size or 512
            conditions = f"{side} x {side} pixels, {spps[0]} spp, {seeds} repetitions, means in seconds"
        else:
            errors = samplers.measure_samplers(scenes, size or 256, spps, range(seeds), progress)
            table, numbers = samplers.markdown(errors), samplers.numbers(errors)
            conditions = f"{size or 256} pixels wide, seeds 0 to {seeds - 1}"
    write_record(output, name, numbers, table, conditions)
    typer.echo(table)
