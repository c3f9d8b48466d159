"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer


class Panel:
    """Headings under which the help of ``render`` groups its options."""

    STOP = "When to stop, and how to go on"
    WHERE = "Where the samples go"
    WHO = "Who draws them"


def criteria_names() -> list[str]:
    """Return the names of all criteria, for completion on the command line."""
    from tracer import criteria

    return criteria.names()


def objective_names() -> list[str]:
    """Return the names of all objectives, for completion on the command line."""
    from tracer.image.objective import OBJECTIVES

    return list(OBJECTIVES)


def given(context: typer.Context) -> dict[str, Any]:
    """Return the values that were given on the command line, without defaults, by the names of the parameters."""

    def is_given(name: str) -> bool:
        source = context.get_parameter_source(name)
        return source is not None and source.name == "COMMANDLINE"

    return {name: value for name, value in context.params.items() if is_given(name)}


SceneFile = Annotated[Path, typer.Argument(help="Mitsuba scene file (XML).", show_default=False)]
Objective = Annotated[str, typer.Option(help="Which error is to be small: relative, absolute or display.")]
Integrator = Annotated[str | None, typer.Option(help="Plugin to use instead of the scene's integrator.")]
Sensor = Annotated[int, typer.Option(help="Number of the scene's sensor, from 0.")]
Width = Annotated[int | None, typer.Option(help="Width in pixels instead of the scene's; the aspect is kept.")]
Workers = Annotated[
    int | None, typer.Option(min=1, help="Processes on this machine that draw.", rich_help_panel=Panel.WHO)
]
Scheduler = Annotated[
    str | None, typer.Option(help="Address of a Dask scheduler, or its file.", rich_help_panel=Panel.WHO)
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")]
Layers = Annotated[
    str | None, typer.Option(help="What the EXR holds: all, or rgb, as textures and environments are. (all)")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object a picture, for machines.")]
