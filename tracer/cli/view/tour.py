"""Command ``view tour``."""

from __future__ import annotations

from typing import Annotated

import typer

from tracer.cli import options
from tracer.cli.view import common


def tour(
    source: common.Source,
    output: common.Output,
    measure: common.Measure = "entropy",
    steps: Annotated[int, typer.Option(help="Steps of the camera.", min=1, max=1000)] = 40,
    step: Annotated[float, typer.Option(help="Length of a step in degrees.", min=0.1, max=45)] = 6.0,
    frames: Annotated[int, typer.Option(help="Pictures of the film.", min=2, max=10000)] = 121,
    size: Annotated[int, typer.Option(help="Width and height of the pictures.", min=16, max=4096)] = 320,
    surfaces: common.Surfaces = None,
    side: common.Side = 256,
    background: common.Background = True,
    distance: common.Distance = None,
    centre: common.Centre = None,
    up: common.Up = None,
    orthographic: common.Orthographic = None,
    repeat: common.Repeat = None,
    cut: common.Cut = None,
    atom_radius: common.AtomRadius = None,
    spp: common.Samples = 0,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Explore with a camera that starts at the best view, and make a film.

    Example: tracer view tour scene.xml -o tour
    """
    from tracer.cli.show import simple_table
    from tracer.errors import OutputError
    from tracer.viewpoint import measures as known
    from tracer.viewpoint.reports import tour as report

    known.get(measure)
    if not overwrite and any(output.glob("frame[0-9][0-9][0-9][0-9].png")):
        raise OutputError(f"'{output}' has frames of another tour; choose another folder, or --overwrite.")
    with common.desk(
        source,
        output,
        report.FILES,
        surfaces=surfaces,
        side=side,
        background=background,
        distance=distance,
        centre=centre,
        up=up,
        orthographic=orthographic,
        repeat=repeat,
        cut=cut,
        atom_radius=atom_radius,
        overwrite=overwrite,
        quiet=quiet,
        spp=spp,
    ) as desk:
        lines = report.tour(desk, measure, steps, step, frames, size)
    if not quiet:
        simple_table(report.HEADINGS, lines, measure)
