"""Command ``view best``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from tracer.cli.options import Panel, advanced, basic
from tracer.cli.view import common


@common.with_view_options()
def best(
    view: common.ViewOptions,
    measure: common.Measure = "entropy",
    good: Annotated[
        str | None,
        advanced(
            "Whether good views have the most or the least. (as the measure says; of crystals the least entropy)",
            Panel.MEASURE,
            metavar="most|least",
        ),
    ] = None,
    search: Annotated[
        list[str] | None,
        advanced(
            "paper (Plemenos and others), octants (it from all 8 triangles) or exhaustive; may be repeated. (all)",
            Panel.MEASURE,
            metavar="NAME",
        ),
    ] = None,
    level: Annotated[int, common.level(3)] = 3,
    other: Annotated[
        Path | None,
        basic("Seen from the surface of this molecule.", Panel.STAND, name="--from", metavar="FILE"),
    ] = None,
) -> None:
    """Find the best view, by the search of Plemenos, Sbert and Feixas (2004) and by trying views from all around.

    The scene is looked at from inside if it is a room. Example: tracer view best scene.xml -m entropy -o best
    """
    from tracer.cli.show import simple_table
    from tracer.errors import SettingsError
    from tracer.viewpoint import measures as known
    from tracer.viewpoint.reports import best as report
    from tracer.viewpoint.reports import best_inside, best_site

    known.get(measure)
    if good not in (None, "most", "least"):
        raise SettingsError(f"Good views have the most or the least, not '{good}'; choose most or least.")
    preferred: known.Best | None = "most" if good == "most" else "least" if good == "least" else None
    searches: list[report.Search] = []
    for name in search or report.SEARCHES:
        if name not in report.SEARCHES:
            raise SettingsError(f"Unknown search '{name}'; choose one of {', '.join(report.SEARCHES)}.")
        searches += [known_search for known_search in report.SEARCHES if known_search == name]
    if other is not None and search:
        raise SettingsError("From the surface of a molecule all points are tried: leave out --search.")
    files = best_site.FILES if other is not None else (*report.FILES, *best_inside.FILES)
    with common.view_context(view, files, other, may_be_inside=True) as context:
        headings: tuple[str, ...]
        if context.pair is not None:
            headings, lines = best_site.HEADINGS, best_site.best_site(context, context.pair, measure, preferred)
        elif context.room is not None:
            if search:
                raise SettingsError("Inside a room there is one search: leave out --search, or give --outside.")
            headings, lines = (
                best_inside.HEADINGS,
                best_inside.best_inside_report(context, context.room, measure, preferred),
            )
        else:
            headings, lines = report.HEADINGS, report.best(context, measure, searches, level, preferred)
    if not view.quiet:
        simple_table(headings, lines, measure)
