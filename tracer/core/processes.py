"""Processes that depend on one another."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from typing import Any

PARENT_DEATH_SIGNAL = 1
"""Number of the operation PR_SET_PDEATHSIG of Linux's ``prctl``: choose the signal that a parent's death sends."""


def die_with(parent: int) -> None:
    """Let this process be killed when the process ``parent`` ends, as nobody could stop it afterwards (Linux only).

    The system kills it, so this works even if this process hangs.
    """
    if sys.platform != "linux":
        return
    library: Any = ctypes.CDLL(None)
    library.prctl(PARENT_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(128 + signal.SIGKILL)
