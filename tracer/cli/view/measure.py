"""Command ``view measure``."""

from __future__ import annotations

from typing import Annotated

import typer

from tracer.cli import options
from tracer.cli.view import common


def measure(
    source: common.Source,
    output: common.Output,
    measures: Annotated[
        list[str] | None, typer.Option("--measure", "-m", help="Measures, several times. (all that can be measured)")
    ] = None,
    level: common.Level = 2,
    surfaces: common.Surfaces = None,
    side: common.Side = 256,
    random: common.Random = None,
    background: common.Background = True,
    distance: common.Distance = None,
    centre: common.Centre = None,
    up: common.Up = None,
    orthographic: common.Orthographic = None,
    repeat: common.Repeat = None,
    cut: common.Cut = None,
    atom_radius: common.AtomRadius = None,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Measure views from all around, and show the best and the worst of each measure.

    Example: tracer view measure bunny.ply -o views
    """
    from tracer.cli.show import simple_table
    from tracer.viewpoint import measures as known
    from tracer.viewpoint.reports import measure as report

    names = [known.get(name).name for name in measures or []]
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
        random=random,
    ) as desk:
        without_mesh = not len(desk.opened.subject.mesh.triangles)
        needs = ({"vertices", "saliency"} if without_mesh else set()) | ({"picture"} if random else set())
        needs |= set() if desk.opened.subject.areas_known else {"areas"}
        names = names or [name for name in known.names() if not needs & set(known.get(name).needs)]
        lines = report.measure(desk, names, level)
    if not quiet:
        simple_table(report.HEADINGS, lines)
