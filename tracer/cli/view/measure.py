"""Command ``view measure``."""

from __future__ import annotations

from typing import Annotated

from tracer.cli.options import basic
from tracer.cli.view import common


@common.with_view_options("spp", "inside")
def measure(
    view: common.ViewOptions,
    measures: Annotated[
        list[str] | None,
        basic("A name below; may be repeated. (all)", name="--measure", short="-m", metavar="NAME"),
    ] = None,
    level: Annotated[int, common.level(2)] = 2,
) -> None:
    """Measure views from all around, and show the best and the worst of each measure.

    Example: tracer view measure bunny.ply -o views
    """
    from tracer.cli.show import simple_table
    from tracer.viewpoint import measures as known
    from tracer.viewpoint.reports import measure as report
    from tracer.viewpoint.survey import unmet_needs

    names = [known.get(name).name for name in measures or []]
    with common.view_context(view, report.FILES, from_outside=True) as context:
        unmet = unmet_needs(context.opened.subject) | ({"picture"} if view.random else set())
        names = names or [name for name in known.names() if not unmet & set(known.get(name).needs)]
        lines = report.measure(context, names, level)
    if not view.quiet:
        simple_table(report.HEADINGS, lines)
