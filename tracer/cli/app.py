"""The program ``tracer`` and its commands."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Annotated, Any

import typer

from tracer.cli import (
    compare,
    demo,
    info,
    merge,
    options,
    radiosity,
    render,
    score,
    study,
    view,
)
from tracer.core.backend import named_library
from tracer.core.version import version
from tracer.core.wording import speaking_to_command_line

app = typer.Typer(
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def show_version(asked: bool) -> None:
    """Print the version, and end the program, if ``asked``."""
    if asked:
        typer.echo(f"tracer {version()}")
        raise typer.Exit


@app.callback()
def program(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=show_version, help="Show the version and exit.")
    ] = False,
) -> None:
    """Render adaptively on Mitsuba 3: look first with cheap rays, spend expensive rays where they pay."""


def after_check(command: Callable[..., None]) -> Callable[..., None]:
    """Return the command with a check for a usable LLVM before it: Dr.Jit loads LLVM as soon as it is imported."""

    @functools.wraps(command)
    def checked(*arguments: Any, **options: Any) -> None:
        named_library()
        with speaking_to_command_line():
            command(*arguments, **options)

    return checked


COMMANDS = (
    render.render,
    merge.merge,
    radiosity.radiosity,
    compare.compare,
    study.study,
    score.score,
    demo.demo,
    info.info,
)
"""All commands but those of ``view``."""
EPILOGS = {
    render.render: f"Criteria: {options.CRITERIA}",
    compare.compare: f"Criteria: {options.CRITERIA}",
    radiosity.radiosity: f"Ways to spread rays: {options.SPREADS}",
}
"""Texts below the help of commands."""
for function in COMMANDS:
    app.command(epilog=EPILOGS.get(function))(after_check(function))
for name, viewing in view.COMMANDS.items():
    view.app.command(name, epilog=view.EPILOGS.get(name))(after_check(viewing))
app.add_typer(view.app, name="view")
