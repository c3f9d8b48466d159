"""Command ``view cover``."""

from __future__ import annotations

from typing import Annotated, cast, get_args

import typer

from tracer.cli.options import Panel, advanced, basic
from tracer.cli.view import common

LEAST_GAIN = 0.02
"""By default, views end when none would show well another such share of the area that can be seen."""
REASONS = {
    "enough": "",
    "views": " by as many views as were asked for",
    "gain": ", and no other view would show well another {gain} of it (--gain)",
}
"""What is said of why views end."""


@common.with_view_options("random", "inside")
def cover(
    view: common.ViewOptions,
    quality: Annotated[
        float,
        advanced(
            "A view shows a surface well if it shows this share of its largest projected area. (0.5)",
            Panel.MEASURE,
            metavar="X",
            min=0.01,
            max=1,
        ),
    ] = 0.5,
    rule: Annotated[
        str,
        advanced(
            "Choose by entropy, by area newly shown, or by divergence from the true areas. (entropy)",
            Panel.MEASURE,
            metavar="NAME",
        ),
    ] = "entropy",
    enough: Annotated[float, basic("Share of what is visible. (0.99)", Panel.END, metavar="X", min=0.01, max=1)] = 0.99,
    gain: Annotated[
        float | None,
        basic("Least share that a view must add. (0.02)", Panel.END, metavar="X", min=0, max=1),
    ] = None,
    views: Annotated[int | None, basic("Most views; --gain is 0 then.", Panel.END, metavar="N", min=1)] = None,
    level: Annotated[int, common.level(2)] = 2,
) -> None:
    """Choose few views that show nearly everything well, for modelling from images.

    Example: tracer view cover bunny.ply -o cover. With --gain 0 --enough 1 views are chosen until all is shown well.
    """
    from tracer.cli.show import simple_table
    from tracer.errors import SettingsError
    from tracer.viewpoint.cover import Rule
    from tracer.viewpoint.reports import cover as report

    if rule not in get_args(Rule):
        raise SettingsError(f"Unknown rule '{rule}'; choose one of {', '.join(get_args(Rule))}.")
    least_gain = gain if gain is not None else 0.0 if views is not None else LEAST_GAIN
    with common.view_context(view, report.FILES, from_outside=True) as context:
        lines, view_set = report.cover_report(context, level, quality, cast(Rule, rule), views, enough, least_gain)
        count = context.opened.subject.count
    if view.quiet:
        return
    simple_table(report.HEADINGS, lines)
    typer.echo(
        f"{len(view_set.missing)} of {count} surfaces, {100 * view_set.missing_share:.1f} % of the visible area, "
        f"are not shown well{REASONS[view_set.ended].format(gain=f'{100 * least_gain:g} %')}. {len(view_set.unseen)}, "
        f"{100 * view_set.unseen_area:.1f} % of the whole area, are seen from nowhere."
    )
    if len(view_set.dropped):
        typer.echo(f"{len(view_set.dropped)} views were left out again, as later ones show what they showed.")
