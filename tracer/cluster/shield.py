"""What a worker of this machine's own cluster does first: not hear what a terminal says to all processes of a command.

The client alone hears Ctrl-C, or whoever stops a service, and lets workers go when it has kept what there is.
"""

from __future__ import annotations

import signal
from typing import Any


def dask_setup(worker: Any) -> None:
    """Called by Dask when a worker begins, in its first thread."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
