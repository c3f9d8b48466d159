"""Connect to workers: start a cluster on this machine, or use one that is running."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tracer.core.version import install_command
from tracer.errors import ClusterError, SettingsError, TracerError

try:
    import dask
    import distributed
    from distributed.comm.addressing import parse_address
    from distributed.comm.registry import get_backend
except ImportError:
    raise ClusterError(f"Workers need Dask distributed; install it, {install_command('cluster')}.") from None

from tracer.cluster.bundle import Bundle, pack
from tracer.cluster.event_loop import event_loop
from tracer.cluster.round_policy import MOST_DEATHS, silent_workers
from tracer.cluster.worker_scene import THREADS
from tracer.cluster.worker_setup import Setup, require_same, software
from tracer.cluster.worker_task import prepare

logger = logging.getLogger(__name__)

LONGEST_WAIT = 20.0
"""Most seconds to wait for a scheduler, or for its first worker."""


@dataclass(frozen=True)
class Connection:
    """A connection to the scheduler of the workers that draw."""

    client: Any
    """The ``distributed.Client``."""
    address: str
    """Address of the scheduler."""
    warming: list[Any] = field(default_factory=list)
    """Futures of the workers that were told to open a scene; Dask drops a task whose future nobody holds."""

    def workers(self) -> dict[str, int]:
        """Return the number of threads of each worker, by its address."""
        return dict(self.client.nthreads())

    def silent(self) -> set[str]:
        """Return the workers that the scheduler has not heard from for long although it has heard from others."""
        workers = self.client.scheduler_info(n_workers=-1).get("workers", {})
        return silent_workers({name: worker["last_seen"] for name, worker in workers.items()})

    def ship(self, setup: Setup) -> None:
        """Send a scene with all of its files to all workers, and to those that join later. Raises ClusterError."""
        archive = pack(Path(setup.scene), dict(setup.define))
        self.client.register_plugin(Bundle(setup.scene_hash, archive))

    def begin(self, setup: Setup) -> None:
        """Let all workers begin to open a scene, while the client opens it, too."""
        self.warming[:] = [
            self.client.submit(prepare, setup, workers=[worker], pure=False) for worker in self.workers()
        ]
        for future in self.warming:
            future.add_done_callback(log_failure)


def log_failure(future: Any) -> None:
    """Log why a worker could not open a scene, unless the reason is a person's mistake."""
    error = future.exception() if future.status == "error" else None
    # A person's mistake is raised by the client or by the first unit, and a missing scene is sent after that unit.
    if error is not None and not isinstance(error, TracerError):
        logger.warning(
            "A worker did not warm up (%s: %s); it does so with its first unit.", type(error).__name__, error
        )


@contextmanager
def open_connection(cluster: Any) -> Iterator[Connection]:
    """Connect to workers. ``cluster``: their number on this machine, the address of a scheduler, or a Dask client.

    Raises ClusterError if there are no workers, or if they do not have the same software as this process; raises
    SettingsError for a ``cluster`` of another type.
    """
    if isinstance(cluster, distributed.Client):
        yield checked(Connection(cluster, str(cluster.scheduler.address)))
    elif isinstance(cluster, str):
        be_quiet()
        with connected(cluster) as client:
            yield checked(Connection(client, str(client.scheduler.address)))
    elif isinstance(cluster, int) and cluster >= 1:
        be_quiet()
        with own_cluster(cluster) as address, connected(address) as client:
            yield checked(Connection(client, str(client.scheduler.address)))
    else:
        raise SettingsError(f"A cluster is a number of workers, an address, or a dask client, not {cluster!r}.")


def be_quiet() -> None:
    """Switch off Dask's log of workers that come and go: a failure reaches us through the future of the task."""
    for name in logging.root.manager.loggerDict:
        if name.startswith("distributed"):
            logging.getLogger(name).setLevel(logging.CRITICAL)


@contextmanager
def own_cluster(workers: int) -> Iterator[Any]:
    """Run workers on this machine, which share its threads and cannot be reached from another machine."""
    threads = max(1, len(os.sched_getaffinity(0)) // workers)
    settings = {
        "distributed.scheduler.allowed-failures": MOST_DEATHS,
        # worker-ttl stays at Dask's five minutes. It ends a worker that hangs, but would also end one that gives no
        # sign of life while it opens a scene. Other workers draw the units of a worker that hangs long before.
        # Dask looks so long after a worker was lost whether it is there again, and if it is not, gives it up for good:
        # also if it has come back since, and is just being started once more.
        "distributed.deploy.lost-worker-timeout": "100 days",
        # We deal out the units ourselves. A worker that hangs looks idle, so Dask would move units of others to it.
        "distributed.scheduler.work-stealing": False,
        # Nobody looks at Dask's monitors here, and they take time from the threads that draw.
        "distributed.worker.profile.enabled": False,
        "distributed.admin.tick.interval": "1s",
        "distributed.admin.system-monitor.interval": "10s",
        "distributed.admin.system-monitor.gil.enabled": False,
        "distributed.scheduler.active-memory-manager.start": False,
    }
    with (
        event_loop() as loop,
        dask.config.set(settings),
        distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=threads + 1,  # the next unit waits in the additional thread while one is drawn
            resources={THREADS: threads},
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            worker_dashboard_address="127.0.0.1:0",
            memory_limit=0,  # else workers pause without a message when they hold much memory
            silence_logs=logging.CRITICAL,
            loop=loop,
            preload="tracer.cluster.shield",
        ) as cluster,
    ):
        yield cluster


@contextmanager
def connected(cluster: Any) -> Iterator[Any]:
    """Connect to a scheduler, given as a cluster, an address, or the file with its address. Raises ClusterError."""
    with event_loop() as loop:
        try:
            if isinstance(cluster, str) and Path(cluster).is_file():
                where = {"scheduler_file": cluster}
            else:
                if isinstance(cluster, str):
                    get_backend(parse_address(cluster, strict=True)[0])  # the client would wait for a wrong address
                where = {"address": cluster}
            client = distributed.Client(**where, timeout=LONGEST_WAIT, set_as_default=False, loop=loop)
        except (OSError, TimeoutError, ValueError, TypeError) as error:
            said = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise ClusterError(f"Cannot connect to the scheduler '{cluster}': {said}.") from None
        try:
            yield client
        finally:
            close(client)


def close(client: Any) -> None:
    """Let go of a client. What Dask raises meanwhile must not take the place of what the block has raised."""
    try:
        client.close(timeout=5)
    except Exception as error:  # such as RuntimeError in its attempt to reconnect to a scheduler that is gone
        logger.debug("Dask could not close its client: %s", error)


def checked(connection: Connection) -> Connection:
    """Return a connection if it has workers, and all have the software of this process. Raises ClusterError."""
    try:
        connection.client.wait_for_workers(1, timeout=LONGEST_WAIT)
    except TimeoutError:
        raise ClusterError(
            f"The scheduler {connection.address} has no workers; start one with 'dask worker'."
        ) from None
    present = sorted(set(connection.workers()) - connection.silent())  # a worker that hangs would never answer
    for worker, answer in connection.client.run(software, workers=present, on_error="return").items():
        if isinstance(answer, Exception):
            raise ClusterError(
                f"Worker {worker} cannot load tracer ({type(answer).__name__}: {answer}); "
                "install the same version there."
            )
        require_same(answer, software(), worker)
    return connection
