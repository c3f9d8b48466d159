"""The command line: a file for each command, which only parses, calls and prints.

Exit codes: 0 done; 1 some cells of a study failed; 2 a mistake that the user can mend, explained in one sentence; 3
Mitsuba crashed; 4 a cluster failed, or cannot be reached; 5 a finished file could not be written, for instance to a
full disk; 130 stopped by Ctrl-C (SIGINT) and 143 by SIGTERM, after writing the results so far; 137 killed, for
instance because memory ran out.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import tracer.cli.startup  # noqa: F401  before anything that takes time
from tracer.cli.guard import guarded
from tracer.errors import SettingsError, TracerError

if TYPE_CHECKING:
    from typer import Typer


def main() -> None:
    """Run the program so that even a crash is reported in one sentence."""
    guarded(run)


def run() -> None:
    """Run the program in this process."""
    from tracer.cli.app import app

    in_one_sentence(lambda: parsed(app, repeat_option(sys.argv[1:], "--spp")))


def parsed(app: Typer, arguments: list[str]) -> None:
    """Run the command that the arguments ask for, and exit with its code. Raises SettingsError if they are mistaken."""
    import typer

    from tracer.cli import mistakes

    usage_error: Any = typer.BadParameter.__base__
    program = typer.main.get_command(app)
    try:
        sys.exit(program(args=arguments, prog_name="tracer", standalone_mode=False))
    except usage_error as error:
        if type(error).__name__ == "NoArgsIsHelpError":
            typer.echo(error.ctx.get_help())
            sys.exit(error.exit_code)
        raise SettingsError(mistakes.in_words(error, program, arguments)) from None


def in_one_sentence(work: Callable[[], None]) -> None:
    """Run ``work``, and report a user's mistake as one sentence on standard error and an exit code."""
    from tracer.cli import signals

    try:
        with signals.interrupting():
            work()
    except TracerError as error:
        sys.stderr.write(f"tracer: {error}\n")
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        sys.stderr.write("tracer: stopped.\n")
        sys.exit(signals.exit_code())


def repeat_option(arguments: list[str], option: str) -> list[str]:
    """Return ``arguments`` with "--spp 16 64" expanded to "--spp 16 --spp 64", which the parser understands."""
    expanded: list[str] = []
    follows = False
    for argument in arguments:
        if follows and argument.isdigit() and expanded[-1] != option:
            expanded.append(option)
        follows = argument == option or (follows and argument.isdigit())
        expanded.append(argument)
    return expanded
