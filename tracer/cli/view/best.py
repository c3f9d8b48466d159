"""Command ``view best``."""

from __future__ import annotations

from typing import Annotated

import typer

from tracer.cli.view import common


@common.with_view_options()
def best(
    view: common.ViewOptions,
    measure: common.Measure = "entropy",
    good: Annotated[
        str | None,
        typer.Option(
            help="Whether good views have the most or the least. (as the measure says; of crystals the least entropy)"
        ),
    ] = None,
    search: Annotated[
        list[str] | None,
        typer.Option(
            help="paper, octants (the paper's, from all 8 triangles) or exhaustive; may be given several times. (all)"
        ),
    ] = None,
    level: common.Level = 3,
) -> None:
    """Find the best view, with the paper's search and by trying views from all around.

    Example: tracer view best scene.xml -m entropy -o best
    """
    from tracer.cli.show import simple_table
    from tracer.errors import SettingsError
    from tracer.viewpoint import measures as known
    from tracer.viewpoint.reports import best as report

    known.get(measure)
    if good not in (None, "most", "least"):
        raise SettingsError(f"Good views have the most or the least, not '{good}'; choose most or least.")
    preferred: known.Best | None = "most" if good == "most" else "least" if good == "least" else None
    searches: list[report.Search] = []
    for name in search or report.SEARCHES:
        if name not in report.SEARCHES:
            raise SettingsError(f"Unknown search '{name}'; choose one of {', '.join(report.SEARCHES)}.")
        searches += [known_search for known_search in report.SEARCHES if known_search == name]
    with common.view_context(view, report.FILES) as context:
        lines = report.best(context, measure, searches, level, preferred)
    if not view.quiet:
        simple_table(report.HEADINGS, lines, measure)
