"""Commands ``view ...``: what is seen from where."""

from __future__ import annotations

from collections.abc import Callable

import typer

from tracer.cli.view import best, common, complexity_map, cover, measure, tour

app = typer.Typer(help="Find good views of a scene, mesh or molecule.", no_args_is_help=True)
COMMANDS: dict[str, Callable[..., None]] = {
    "measure": measure.measure,
    "map": complexity_map.complexity_map,
    "best": best.best,
    "tour": tour.tour,
    "cover": cover.cover,
}
"""These are the commands ``view ...`` by name."""
EPILOGS = dict.fromkeys(("measure", "best", "tour"), f"Measures: {common.MEASURES}")
EPILOGS["map"] = "Kinds: entropy, gini, distinct, viewpoint_complexity"
"""Texts below the help of commands."""
