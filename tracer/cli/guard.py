"""Run the program in a child process, so that a person reads why if Mitsuba aborts or hangs, or memory runs out.

The child is forked before anything large is imported, which takes a millisecond. It has the same terminal and files.
Set TRACER_FORK=0 to run in a single process, for a debugger.
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
"""Names of the signals that end a crashed process."""
GRACE_SECONDS = 25.0
"""Seconds from SIGTERM until a program that has not ended is killed; Slurm and Kubernetes give it 30 seconds."""
GRACE_VARIABLE = "TRACER_GRACE"
"""Environment variable that gives a number of seconds in place of ``GRACE_SECONDS``."""
AT_ONCE_SECONDS = 5.0
"""Seconds from a second signal until the program is killed: time to release workers, but not to write a picture."""


def guarded(work: Callable[[], None]) -> None:
    """Run ``work`` in a child process where the system can fork, and exit with its exit code.

    A child that has not ended some time after SIGTERM is killed, because code of Mitsuba that hangs reacts to no other
    signal.
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
    before = signal.pthread_sigmask(signal.SIG_BLOCK, PASSED_ON)  # until the guard can pass them on
    child = os.fork()
    if child == 0:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        die_with(parent)
        work()
        return
    guard = Guard(child, seconds)
    for signal_number in PASSED_ON:
        signal.signal(signal_number, guard.pass_on)
    signal.signal(signal.SIGALRM, guard.kill)
    signal.pthread_sigmask(signal.SIG_SETMASK, before)
    _, status = os.waitpid(child, 0)
    sys.exit(guard.exit_code(status))


def grace() -> float:
    """Return the seconds from SIGTERM until a program is killed. Raises SettingsError for a variable that is wrong."""
    text = os.environ.get(GRACE_VARIABLE) or str(GRACE_SECONDS)
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise SettingsError(f"{GRACE_VARIABLE} is a number of seconds above 0, not '{text}'.")
    return seconds


class Guard:
    """Passes signals on to a child process, and makes sure that the child ends."""

    def __init__(self, child: int, seconds: float) -> None:
        """Guard process number ``child``, which is killed ``seconds`` after SIGTERM."""
        self.child, self.seconds = child, seconds
        self.first: int | None = None
        """The first signal, from which the exit code follows."""
        self.last = -math.inf
        """Time of the last signal, in seconds."""
        self.killed = False
        """Whether the child has been killed because its time was over."""

    def pass_on(self, signal_number: int, frame: Any) -> None:
        """Send a signal to the child, and set the time by which it must have ended."""
        repeated = self.first is not None and time.monotonic() - self.last > REPEATED_SECONDS
        self.first, self.last = self.first or signal_number, time.monotonic()
        if repeated:
            signal.setitimer(signal.ITIMER_REAL, AT_ONCE_SECONDS)
        elif signal_number == signal.SIGTERM:  # a batch system may not send a second signal
            signal.setitimer(signal.ITIMER_REAL, self.seconds)
        send(self.child, signal_number)

    def kill(self, signal_number: int, frame: Any) -> None:
        """Kill the child, because its time is over."""
        self.killed = True
        send(self.child, signal.SIGKILL)

    def exit_code(self, status: int) -> int:
        """Return the exit code for the ``status`` with which the child ended.

        If the child did not exit by itself, the reason is written to standard error.
        """
        if os.WIFEXITED(status):
            return os.WEXITSTATUS(status)
        if not self.killed or self.first is None:
            return explain(os.WTERMSIG(status))
        sys.stderr.write(
            f"tracer: killed, as it did not end after {signal.Signals(self.first).name}: Mitsuba hangs, or the picture "
            "takes longer to finish; files and checkpoints are as they were last written.\n"
        )
        return 128 + self.first


def send(process: int, signal_number: int) -> None:
    """Send a signal to a process."""
    with contextlib.suppress(ProcessLookupError):  # the process has ended already, as a signal would have it
        os.kill(process, signal_number)


def explain(signal_number: int) -> int:
    """Write to standard error why a signal ended the child, and return the exit code."""
    name = signal.Signals(signal_number).name
    if name in CRASHES:
        sys.stderr.write(
            f"tracer: Mitsuba crashed ({name}), most likely over something in the scene that it does not check; "
            "files and checkpoints are as they were last written.\n"
        )
        return CRASHED
    if signal_number == signal.SIGKILL:
        sys.stderr.write("tracer: killed, most likely as memory ran out; render less at once: see --size and --crop.\n")
    return 128 + signal_number
