"""The command line: one file per command, thin: parse, call, print.

Exit codes: 0 done; 1 a study of which a part failed; 2 a mistake that can be mended, said in one sentence; 3 Mitsuba
crashed; 4 a cluster failed, or is not there; 5 a file could not be written when it was made, as on a full disk; 130
stopped by Ctrl-C (SIGINT), 143 by SIGTERM, with what there was written; 137 killed, as if memory runs out.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import tracer.cli.startup  # noqa: F401  before anything that takes time
from tracer.cli.guard import guarded
from tracer.errors import TracerError


def main() -> None:
    """Run the program so that a crash of it is one sentence, too."""
    guarded(run)


def run() -> None:
    """Run the program."""
    from tracer.cli.app import app

    in_one_sentence(lambda: app(args=repeat_option(sys.argv[1:], "--spp")))


def in_one_sentence(work: Callable[[], None]) -> None:
    """Run ``work``; a person's mistake is one sentence on standard error and an exit code."""
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
    """Return ``arguments`` with "--spp 16 64" written out as "--spp 16 --spp 64", which the parser understands."""
    expanded: list[str] = []
    follows = False
    for argument in arguments:
        if follows and argument.isdigit() and expanded[-1] != option:
            expanded.append(option)
        follows = argument == option or (follows and argument.isdigit())
        expanded.append(argument)
    return expanded
