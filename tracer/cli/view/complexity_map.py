"""Command ``view map``."""

from __future__ import annotations

from typing import Annotated

from tracer.cli.options import Panel, advanced, basic
from tracer.cli.view import common


@common.with_view_options("distance", "random", "spp", "inside", "weight", "by_light")
def complexity_map(
    view: common.ViewOptions,
    kind: Annotated[
        str, basic("A name below. (entropy)", Panel.MEASURE, name="--kind", short="-k", metavar="NAME")
    ] = "entropy",
    sensor: Annotated[int, basic("Which camera of the scene. (0)", Panel.STAND, metavar="N", min=0)] = 0,
    eye: Annotated[
        common.Three | None, basic("Look from here at the centre.", Panel.STAND, name="--from", metavar="X Y Z")
    ] = None,
    blocks: Annotated[int, basic("Blocks across the image. (32)", Panel.MEASURE, metavar="N", min=1, max=256)] = 32,
    level: Annotated[
        int, advanced("Triangles around the eye: 8 * 4^level. (3)", Panel.MEASURE, metavar="N", min=0, max=5)
    ] = 3,
) -> None:
    """Show how complex each part of one view is: blocks of the image, and triangles all around the eye.

    Example: tracer view map scene.xml --surfaces shape -o map
    """
    from dataclasses import replace

    import numpy as np

    from tracer.cli.show import simple_table
    from tracer.errors import SettingsError
    from tracer.viewpoint.reports import complexity_map as report

    if kind not in report.KINDS:
        raise SettingsError(f"Unknown kind of complexity '{kind}'; choose one of {', '.join(report.KINDS)}.")
    if eye is not None and not np.all(np.isfinite(eye)):
        raise SettingsError("A place or direction must be three finite numbers.")
    with common.view_context(view, report.FILES) as context:
        viewpoint, lens = report.view_from(context, sensor, eye)
        stand = replace(context.stand, lens=lens)
        lines = report.complexity_map(replace(context, stand=stand), viewpoint, kind, blocks, level)
    if not view.quiet:
        simple_table(report.HEADINGS, lines)
