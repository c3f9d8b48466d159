"""A process that runs command lines of ``tracer`` one after the other, below the fork that turns crashes into words.

It reads one JSON line a command from standard input, ``{"arguments": [...], "folder": "..."}``, and answers each with
one, ``{"code": 2}``. What a command prints, by Mitsuba's C++ too, goes to the two files that the process is given.
"""

import json
import os
import resource
import sys
import traceback

MEMORY = 12 << 30
"""Bytes of address space: a header that promises a huge picture or mesh must not take the machine down."""


def run(arguments):
    """Run one command; return its exit code."""
    from tracer import cli

    sys.argv = ["tracer", *arguments]
    try:
        cli.run()
    except SystemExit as stopped:
        if isinstance(stopped.code, str):
            print(stopped.code, file=sys.stderr)
            return 1
        return stopped.code or 0
    except BaseException:  # what an interpreter would do with it
        traceback.print_exc()
        return 1
    return 0


def main(out, err):
    """Answer commands until there are none."""
    answers = os.fdopen(os.dup(1), "w")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for number, path in ((1, out), (2, err)):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND), number)
    for line in sys.stdin:
        command = json.loads(line)
        for number in (1, 2):
            os.ftruncate(number, 0)
        os.chdir(command["folder"])
        code = run(command["arguments"])
        sys.stdout.flush()
        sys.stderr.flush()
        print(json.dumps({"code": code}), file=answers, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
