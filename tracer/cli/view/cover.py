"""Command ``view cover``."""

from __future__ import annotations

from typing import Annotated, cast, get_args

import typer

from tracer.cli.view import common


@common.with_view_options("random", "inside")
def cover(
    view: common.ViewOptions,
    quality: Annotated[
        float,
        typer.Option(
            help="A view shows a surface well if it shows this share of its largest projected area.", min=0.01, max=1
        ),
    ] = 0.5,
    rule: Annotated[
        str, typer.Option(help="Choose by entropy, by area newly shown, or by divergence from the true areas.")
    ] = "entropy",
    enough: Annotated[
        float, typer.Option(help="End when this share of the visible area is shown well.", min=0.01, max=1)
    ] = 0.99,
    most: Annotated[int | None, typer.Option(help="End after this many views.", min=1)] = None,
    level: common.Level = 2,
) -> None:
    """Choose the fewest views that show everything well, for modelling from images.

    Example: tracer view cover bunny.ply -o cover
    """
    from tracer.cli.show import simple_table
    from tracer.errors import SettingsError
    from tracer.viewpoint.cover import Rule
    from tracer.viewpoint.reports import cover as report

    if rule not in get_args(Rule):
        raise SettingsError(f"Unknown rule '{rule}'; choose one of {', '.join(get_args(Rule))}.")
    with common.view_context(view, report.FILES) as context:
        lines, view_set = report.cover_report(context, level, quality, cast(Rule, rule), most, enough)
        count = context.opened.subject.count
    if view.quiet:
        return
    simple_table(report.HEADINGS, lines)
    typer.echo(
        f"{len(view_set.unseen)} of {count} surfaces, {100 * view_set.unseen_area:.1f} % of the area, "
        f"are seen from nowhere; {len(view_set.dropped)} views became superfluous"
    )
