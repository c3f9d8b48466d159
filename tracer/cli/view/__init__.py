"""Commands ``view ...``: what is seen from where."""

from __future__ import annotations

import typer

from tracer.cli.view import best, cover, measure, report, tour

app = typer.Typer(help="Find good views of a scene, mesh or molecule.", no_args_is_help=True)
COMMANDS = (measure.measure, best.best, tour.tour, cover.cover, report.report)
