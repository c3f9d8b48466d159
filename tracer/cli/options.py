"""Options that several commands share."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer


class Panel:
    """Headings under which help groups options: those of ``render``, of ``radiosity``, and then those of ``view``."""

    STOP = "When to stop, and how to go on"
    WHERE = "Where the samples go"
    WHO = "Who draws them"

    LUX = "Illuminance and patches"
    SOLUTION = "How the light of patches is solved"

    MEASURE = "What is measured"
    SURFACES = "What counts as a surface"
    STAND = "From where it is seen"
    ATOMS = "Molecules and crystals"
    FILM = "The film"
    END = "When a set of views is large enough"


HELP_WIDTH = 78
"""Letters in a line of a list of names."""


def names_in(folder: str, decorator: str) -> str:
    """Return the names that the files of a folder of ``tracer`` register by a decorator, in lines for help.

    The files are read and not imported, which would take seconds.
    """
    pattern = re.compile(rf'^@{decorator}\("(\w+)"', re.MULTILINE)
    paths = (Path(__file__).parents[1] / folder).glob("*.py")
    names = sorted(name for path in paths for name in pattern.findall(path.read_text(encoding="utf-8")))
    return f"\n{textwrap.fill(', '.join(names), HELP_WIDTH)}\n"


CRITERIA = names_in("criteria", "criterion")
"""Names of all criteria, for help."""
OBJECTIVES = "relative, absolute or display"
"""Names of all objectives, for help."""

SPREADS = """
guided (usual for gathering), evenly (usual for shooting), randomly,
paper (the paper's rules as printed), paper_right (with energies made right)
"""
"""How the rays of patches can be spread, for help."""


def advanced(
    help: str,
    panel: str | None = None,
    *,
    name: str | None = None,
    short: str | None = None,
    metavar: str | None = None,
    min: float | None = None,
    max: float | None = None,
) -> Any:
    """Return an option that only ``--help-all`` shows; its ``name`` is that of the parameter if it is None.

    ``help`` tells the default in brackets.
    """
    return basic(help, panel, name=name, short=short, metavar=metavar, min=min, max=max, hidden=True)


def basic(
    help: str, panel: str | None = None, *, name: str | None = None, short: str | None = None, **more: Any
) -> Any:
    """Return an option that ``--help`` shows in a line; its ``name`` is that of the parameter if it is None.

    ``help`` tells the default in brackets.
    """
    names = [declared for declared in (name, short) if declared is not None]
    return typer.Option(*names, help=help, rich_help_panel=panel, show_default=False, **more)


@contextmanager
def all_shown(command: Any) -> Iterator[None]:
    """Let the help of a command show all options while the block runs."""
    hidden = [parameter for parameter in command.params if getattr(parameter, "hidden", False)]
    try:
        for parameter in hidden:
            parameter.hidden = False
        yield
    finally:
        for parameter in hidden:
            parameter.hidden = True


def show_all(context: typer.Context, asked: bool) -> None:
    """Show the help with all options, and end the program, if ``asked``."""
    if asked:
        with all_shown(context.command):
            typer.echo(context.get_help())
        raise typer.Exit


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
Objective = Annotated[str, typer.Option(help=f"Which error is to be small: {OBJECTIVES}.", metavar="NAME")]
Integrator = Annotated[str | None, typer.Option(help="Plugin to use instead of the scene's integrator.")]
Sensor = Annotated[int, typer.Option(help="Number of the scene's sensor, from 0.")]
Width = Annotated[int | None, typer.Option(help="Width of the picture; the aspect is kept.", metavar="PIXELS")]
Workers = Annotated[
    int | None, typer.Option(min=1, help="Processes on this machine that draw.", metavar="N", rich_help_panel=Panel.WHO)
]
Scheduler = Annotated[
    str | None, typer.Option(help="Address of a Dask scheduler, or its file.", rich_help_panel=Panel.WHO)
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")]
Layers = Annotated[
    str | None,
    typer.Option(help="rgb: an EXR without layers. (all)", metavar="all|rgb"),
]
HelpAll = Annotated[
    bool, typer.Option("--help-all", is_eager=True, callback=show_all, help="Show the other options, too.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object a picture, for machines.")]
