"""Command ``view best``."""

from __future__ import annotations

from typing import Annotated

import typer

from tracer.cli import options
from tracer.cli.view import common


def best(
    source: common.Source,
    output: common.Output,
    measure: common.Measure = "entropy",
    good: Annotated[
        str | None, typer.Option(help="Wanted is the most or the least. [as measured; least entropy of crystals]")
    ] = None,
    search: Annotated[
        list[str] | None,
        typer.Option(help="paper, octants (the paper's from all 8 triangles), exhaustive; several times. (all)"),
    ] = None,
    level: common.Level = 3,
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
    spp: common.Samples = 0,
    overwrite: options.Overwrite = False,
    quiet: options.Quiet = False,
) -> None:
    """Find the best view, as the paper does and by trying all around.

    Example: tracer view best scene.xml -m entropy -o best
    """
    from tracer.cli.show import simple_table
    from tracer.errors import SettingsError
    from tracer.viewpoint import measures as known
    from tracer.viewpoint.reports import best as report

    known.get(measure)
    if good not in (None, "most", "least"):
        raise SettingsError(f"Wanted is the most or the least, not '{good}'.")
    wanted: known.Best | None = "most" if good == "most" else "least" if good == "least" else None
    searches: list[report.Search] = []
    for name in search or report.SEARCHES:
        if name not in report.SEARCHES:
            raise SettingsError(f"Unknown search '{name}'; choose one of {', '.join(report.SEARCHES)}.")
        searches += [one for one in report.SEARCHES if one == name]
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
        spp=spp,
    ) as desk:
        lines = report.best(desk, measure, searches, level, wanted)
    if not quiet:
        simple_table(report.HEADINGS, lines, measure)
