"""What a worker of this machine's own cluster does first: hear the client alone, and end with it.

It does not hear what a terminal, or whoever stops a service, says to all processes of a command: the client lets
workers go when it has kept what there is. One that hangs ends all the same when the client is gone.
"""

from __future__ import annotations

import multiprocessing
import signal
from typing import Any

from tracer.core.processes import die_with


def dask_setup(worker: Any) -> None:
    """Called by Dask when a worker begins, in its first thread."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    client = multiprocessing.parent_process()
    if client is not None and client.pid is not None:
        die_with(client.pid)
