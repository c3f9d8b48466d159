"""Run the program in a child process: where Mitsuba aborts on a scene, or memory runs out, a person reads a sentence.

The child is forked before anything large is imported, which takes a millisecond and changes nothing else: it has the
same terminal and files. Set TRACER_FORK=0 to run in one process, for a debugger.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
from collections.abc import Callable
from typing import Any

CRASHED = 3
"""Exit code when Mitsuba has crashed."""
CRASHES = ("SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL", "SIGTRAP")
PARENT_DEATH_SIGNAL = 1
"""PR_SET_PDEATHSIG of Linux's prctl."""


def guarded(work: Callable[[], None]) -> None:
    """Run ``work`` in a child process where there is fork, and exit as it does."""
    if not hasattr(os, "fork") or os.environ.get("TRACER_FORK") == "0":
        work()
        return
    parent = os.getpid()
    child = os.fork()
    if child == 0:
        die_with(parent)
        work()
        return
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, frame: send(child, number))
    _, status = os.waitpid(child, 0)
    if os.WIFEXITED(status):
        sys.exit(os.WEXITSTATUS(status))
    sys.exit(explain(os.WTERMSIG(status)))


def send(process: int, number: int) -> None:
    """Send a signal to a process, if it is still there."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(process, number)


def die_with(parent: int) -> None:
    """Let this process be killed when its parent is, as nobody could stop it then (Linux only)."""
    if sys.platform != "linux":
        return
    library: Any = ctypes.CDLL(None)
    library.prctl(PARENT_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(128 + signal.SIGKILL)


def explain(number: int) -> int:
    """Say why the child was ended by a signal; return the exit code."""
    name = signal.Signals(number).name
    if name in CRASHES:
        sys.stderr.write(
            f"tracer: Mitsuba crashed ({name}), most likely over something in the scene that it does not check; "
            "files and checkpoints are as they were last written.\n"
        )
        return CRASHED
    if number == signal.SIGKILL:
        sys.stderr.write("tracer: killed, most likely as memory ran out; render less at once: see --size and --crop.\n")
    return 128 + number
