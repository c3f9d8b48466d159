"""Command ``view tour``."""

from __future__ import annotations

from typing import Annotated, cast, get_args

import typer

from tracer.cli.options import Panel, advanced, basic
from tracer.cli.view import common


@common.with_view_options("random")
def tour(
    view: common.ViewOptions,
    measure: common.Measure = "entropy",
    steps: Annotated[int, advanced("Steps of the camera. (40)", Panel.FILM, metavar="N", min=1, max=1000)] = 40,
    step: Annotated[
        float,
        advanced(
            "Degrees of a step; inside, steps lead to the next place. (6)", Panel.FILM, metavar="X", min=0.1, max=45
        ),
    ] = 6.0,
    avoid: Annotated[
        str,
        advanced(
            "Keep away from the start (formula of Plemenos and others) or from all visited places (text). (start)",
            Panel.FILM,
            metavar="start|visited",
        ),
    ] = "start",
    frames: Annotated[int, basic("Pictures in it, 2 or more. (121)", Panel.FILM, metavar="N", min=2, max=10000)] = 121,
    size: Annotated[int, basic("Width and height. (640)", Panel.FILM, metavar="PIXELS", min=16, max=4096)] = 640,
    film: Annotated[str, basic(".webp or .mp4 (H.264). (tour.webp)", Panel.FILM, metavar="FILE")] = "tour.webp",
    loop: Annotated[bool, basic("Come back to the start.", Panel.FILM, name="--loop")] = False,
) -> None:
    """Explore with a camera that starts at the best view, and make a film.

    Example: tracer view tour scene.xml -o tour
    """
    from tracer.cli.show import simple_table
    from tracer.errors import OutputError, SettingsError
    from tracer.viewpoint import measures as known
    from tracer.viewpoint.films import require_film_maker
    from tracer.viewpoint.reports import tour as report
    from tracer.viewpoint.reports.tour_inside import tour_inside
    from tracer.viewpoint.tour import Avoided

    known.get(measure)
    if avoid not in get_args(Avoided):
        raise SettingsError(f"A tour avoids {' or '.join(get_args(Avoided))}, not '{avoid}'.")
    if not view.overwrite and any(view.output.glob("frame[0-9][0-9][0-9][0-9].png")):
        raise OutputError(f"'{view.output}' has frames of another tour; choose another folder, or --overwrite.")
    require_film_maker(film)
    with common.view_context(view, (film, *report.FILES), may_be_inside=True) as context:
        shown = report.Film(frames, size, film, loop)
        if context.room is None:
            lines = report.tour(context, measure, steps, step, shown, cast(Avoided, avoid))
        else:
            lines = tour_inside(context, context.room, measure, steps, shown, cast(Avoided, avoid))
    if not view.quiet:
        simple_table(report.HEADINGS, lines, measure)
        typer.echo(f"The film is {view.output / film}.")
