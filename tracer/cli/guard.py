"""Run the program in a child process: where Mitsuba aborts on a scene or hangs, or memory runs out, a person reads why.

The child is forked before anything large is imported, which takes a millisecond and changes nothing else: it has the
same terminal and files. Set TRACER_FORK=0 to run in one process, for a debugger.
"""

from __future__ import annotations

import contextlib
import math
import os
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

from tracer.cli.signals import HANDLED as PASSED_ON
from tracer.cli.signals import REPEATED_SECONDS
from tracer.core.processes import die_with
from tracer.errors import SettingsError

CRASHED = 3
"""Exit code when Mitsuba has crashed."""
CRASHES = ("SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL", "SIGTRAP")
GRACE_SECONDS = 25.0
"""From SIGTERM until a program that has not ended is killed: within the 30 seconds that Slurm and Kubernetes give."""
GRACE_VARIABLE = "TRACER_GRACE"
"""Names other seconds in the environment."""
AT_ONCE_SECONDS = 5.0
"""The same from a second signal, which asks for no picture: time to let workers go."""


def guarded(work: Callable[[], None]) -> None:
    """Run ``work`` in a child process where there is fork, and exit as it does.

    A child that has not ended some time after SIGTERM is killed: code of Mitsuba that waits for ever hears no signal.
    """
    if not hasattr(os, "fork") or os.environ.get("TRACER_FORK") == "0":
        work()
        return
    try:
        seconds = grace()
    except SettingsError as error:
        sys.stderr.write(f"tracer: {error}\n")
        sys.exit(error.exit_code)
    parent = os.getpid()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, PASSED_ON)  # until there is somebody to pass them on
    child = os.fork()
    if child == 0:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        die_with(parent)
        work()
        return
    guard = Guard(child, seconds)
    for number in PASSED_ON:
        signal.signal(number, guard.pass_on)
    signal.signal(signal.SIGALRM, guard.kill)
    signal.pthread_sigmask(signal.SIG_SETMASK, before)
    _, status = os.waitpid(child, 0)
    sys.exit(guard.exit_code(status))


def grace() -> float:
    """Return the seconds that a program has after SIGTERM. Raises SettingsError."""
    said = os.environ.get(GRACE_VARIABLE) or str(GRACE_SECONDS)
    try:
        seconds = float(said)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise SettingsError(f"{GRACE_VARIABLE} is a number of seconds above 0, not '{said}'.")
    return seconds


class Guard:
    """Passes signals on to a child process, and sees to it that it ends."""

    def __init__(self, child: int, seconds: float) -> None:
        """``seconds``: from SIGTERM until it is killed."""
        self.child, self.seconds = child, seconds
        self.first: int | None = None
        """The first signal, which the exit code tells."""
        self.last = -math.inf
        self.killed = False

    def pass_on(self, number: int, frame: Any) -> None:
        """Send a signal to the child, and set the time by which it must have ended."""
        repeated = self.first is not None and time.monotonic() - self.last > REPEATED_SECONDS
        self.first, self.last = self.first or number, time.monotonic()
        if repeated:
            signal.setitimer(signal.ITIMER_REAL, AT_ONCE_SECONDS)
        elif number == signal.SIGTERM:  # nobody may be there to say it twice
            signal.setitimer(signal.ITIMER_REAL, self.seconds)
        send(self.child, number)

    def kill(self, number: int, frame: Any) -> None:
        """Kill the child: its time is over."""
        self.killed = True
        send(self.child, signal.SIGKILL)

    def exit_code(self, status: int) -> int:
        """Return the exit code for the ``status`` with which the child ended; say why if it did not exit by itself."""
        if os.WIFEXITED(status):
            return os.WEXITSTATUS(status)
        if not self.killed or self.first is None:
            return explain(os.WTERMSIG(status))
        sys.stderr.write(
            f"tracer: killed, as it did not end after {signal.Signals(self.first).name}: Mitsuba hangs, or the picture "
            "takes longer to finish; files and checkpoints are as they were last written.\n"
        )
        return 128 + self.first


def send(process: int, number: int) -> None:
    """Send a signal to a process."""
    with contextlib.suppress(ProcessLookupError):  # it has ended, which is all that a signal could bring about
        os.kill(process, number)


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
