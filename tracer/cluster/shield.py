"""What a worker started by ``--workers`` does first: it obeys the client alone, and ends when the client ends.

The worker ignores the signals that a terminal or a service manager sends to all processes of a command, as the client
ends its workers itself after it has kept what there is. A worker that hangs ends as well when the client is gone.
"""

from __future__ import annotations

import multiprocessing
import signal
from typing import Any

from tracer.core.processes import die_with


def dask_setup(worker: Any) -> None:
    """Prepare a worker. Dask calls this function when a worker begins, in its first thread."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    client = multiprocessing.parent_process()
    if client is not None and client.pid is not None:
        die_with(client.pid)
