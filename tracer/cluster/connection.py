"""Connect to workers: a cluster of this machine's own, or one that is there."""

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
from tracer.cluster.round_policy import silent_workers
from tracer.cluster.worker_scene import THREADS
from tracer.cluster.worker_setup import Setup, require_same, software
from tracer.cluster.worker_task import prepare

logger = logging.getLogger(__name__)

LONGEST_WAIT = 20.0
"""Seconds to wait for a scheduler, or for its first worker."""
MOST_DEATHS = 5
"""Workers that may die over one unit before it is taken to be what kills them; of a cluster of our own."""


@dataclass(frozen=True)
class Connection:
    """To the scheduler of workers that draw."""

    client: Any
    """``distributed.Client``."""
    address: str
    """Of the scheduler."""
    warming: list[Any] = field(default_factory=list)
    """A future for each worker that was told to open a scene; Dask forgets what nobody holds one for."""

    def workers(self) -> dict[str, int]:
        """Return the threads of each worker, by its address."""
        return dict(self.client.nthreads())

    def silent(self) -> set[str]:
        """Return the workers that the scheduler has not heard of while it heard of others."""
        workers = self.client.scheduler_info(n_workers=-1).get("workers", {})
        return silent_workers({name: each["last_seen"] for name, each in workers.items()})

    def ship(self, setup: Setup) -> None:
        """Send a scene with all of its files to all workers, and to those that come later. Raises ClusterError."""
        archive = pack(Path(setup.scene), dict(setup.define))
        self.client.register_plugin(Bundle(setup.scene_hash, archive))

    def begin(self, setup: Setup) -> None:
        """Let all workers open a scene while the client does so itself."""
        self.warming[:] = [
            self.client.submit(prepare, setup, workers=[worker], pure=False) for worker in self.workers()
        ]
        for future in self.warming:
            future.add_done_callback(log_failure)


def log_failure(future: Any) -> None:
    """Log why a worker could not open a scene, unless that is a mistake of a person."""
    error = future.exception() if future.status == "error" else None
    # A person's mistake is raised by the client or by the first unit; a scene that is missing is sent with that.
    if error is not None and not isinstance(error, TracerError):
        logger.warning(
            "A worker did not warm up (%s: %s); it does so with its first unit.", type(error).__name__, error
        )


@contextmanager
def open_connection(cluster: Any) -> Iterator[Connection]:
    """Connect to workers: ``cluster`` says how many on this machine, or the address of a scheduler, or a client.

    Raises ClusterError if there are none, or if they are not made of the same as this process.
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
    """Let Dask say nothing of workers that come and go: what fails reaches us with the future that was asked for."""
    for name in logging.root.manager.loggerDict:
        if name.startswith("distributed"):
            logging.getLogger(name).setLevel(logging.CRITICAL)


@contextmanager
def own_cluster(workers: int) -> Iterator[Any]:
    """Run workers on this machine, which share its threads, and can be reached from it alone."""
    threads = max(1, len(os.sched_getaffinity(0)) // workers)
    settings = {
        "distributed.scheduler.allowed-failures": MOST_DEATHS,
        # worker-ttl stays at Dask's five minutes: it ends a worker that hangs, but also one that opens a scene for as
        # long without a sign of life, and others draw its units long before.
        # We deal out the units ourselves. A worker that hangs looks idle, so Dask would move units of others to it.
        "distributed.scheduler.work-stealing": False,
        # What nobody looks at here takes time from threads that have other things to do.
        "distributed.worker.profile.enabled": False,
        "distributed.admin.tick.interval": "1s",
        "distributed.admin.system-monitor.interval": "10s",
        "distributed.admin.system-monitor.gil.enabled": False,
        "distributed.scheduler.active-memory-manager.start": False,
    }
    with (
        dask.config.set(settings),
        distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=threads + 1,  # one unit waits at the door while another is drawn
            resources={THREADS: threads},
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            worker_dashboard_address="127.0.0.1:0",
            memory_limit=0,  # else workers pause when they hold much, and nothing says so
            silence_logs=logging.CRITICAL,
            preload="tracer.cluster.shield",
        ) as cluster,
    ):
        yield cluster


@contextmanager
def connected(cluster: Any) -> Iterator[Any]:
    """Connect to a scheduler: a cluster, an address, or the file in which one has left it. Raises ClusterError."""
    try:
        if isinstance(cluster, str) and Path(cluster).is_file():
            where = {"scheduler_file": cluster}
        else:
            if isinstance(cluster, str):
                get_backend(parse_address(cluster, strict=True)[0])  # else the client would wait for what cannot be
            where = {"address": cluster}
        client = distributed.Client(**where, timeout=LONGEST_WAIT, set_as_default=False)
    except (OSError, TimeoutError, ValueError, TypeError) as error:
        said = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise ClusterError(f"Cannot connect to the scheduler '{cluster}': {said}.") from None
    try:
        yield client
    finally:
        client.close(timeout=5)


def checked(connection: Connection) -> Connection:
    """Return a connection if it has workers that are made of the same as this process. Raises ClusterError."""
    try:
        connection.client.wait_for_workers(1, timeout=LONGEST_WAIT)
    except TimeoutError:
        raise ClusterError(
            f"The scheduler {connection.address} has no workers; start one with 'dask worker'."
        ) from None
    present = sorted(set(connection.workers()) - connection.silent())  # one that hangs would never answer
    for worker, found in connection.client.run(software, workers=present, on_error="return").items():
        if isinstance(found, Exception):
            raise ClusterError(
                f"Worker {worker} cannot load tracer ({type(found).__name__}: {found}); install the same version there."
            )
        require_same(found, software(), worker)
    return connection
