"""The command line: one file per command, thin: parse, call, print."""

from __future__ import annotations

import sys

from tracer.errors import TracerError


def main() -> None:
    """Run the program; a person's mistake is one sentence on standard error and an exit code."""
    from tracer.cli.app import app

    try:
        app(args=repeat_option(sys.argv[1:], "--spp"))
    except TracerError as error:
        sys.stderr.write(f"tracer: {error}\n")
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        sys.stderr.write("tracer: stopped.\n")
        sys.exit(130)


def repeat_option(arguments: list[str], option: str) -> list[str]:
    """Return ``arguments`` with "--spp 16 64" written out as "--spp 16 --spp 64", which the parser understands."""
    expanded: list[str] = []
    follows = False
    for argument in arguments:
        if follows and argument.isdigit() and expanded[-1] != option:
            expanded.append(option)
        follows = argument == option or (follows and argument.isdigit())
        expanded.append(argument)
    return expanded
