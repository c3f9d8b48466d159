"""Processes that depend on one another."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from typing import Any

PARENT_DEATH_SIGNAL = 1
"""PR_SET_PDEATHSIG of Linux's prctl."""


def die_with(parent: int) -> None:
    """Let this process be killed when its parent is, as nobody could stop it then (Linux only).

    The system does that, so it holds for a process that hangs, too.
    """
    if sys.platform != "linux":
        return
    library: Any = ctypes.CDLL(None)
    library.prctl(PARENT_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(128 + signal.SIGKILL)
