"""The program ``tracer`` and its commands."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import typer

from tracer.cli import (
    compare,
    demo,
    info,
    merge,
    radiosity,
    render,
    score,
    study,
    view,
)
from tracer.core.backend import named_library
from tracer.core.wording import speaking_to_command_line

app = typer.Typer(
    help="Render adaptively on Mitsuba 3: look first with cheap rays, spend expensive rays where they pay.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


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
for function in COMMANDS:
    app.command()(after_check(function))
for name, viewing in view.COMMANDS.items():
    view.app.command(name)(after_check(viewing))
app.add_typer(view.app, name="view")
