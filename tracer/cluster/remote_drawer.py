"""Make the drawer with which a session draws on workers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import mitsuba as mi

from tracer.cluster.connection import open_connection
from tracer.cluster.round_scheduler import RoundScheduler
from tracer.cluster.worker_setup import make_setup
from tracer.core.plain_values import plain
from tracer.scene.loaded import LoadedScene
from tracer.session.local_drawer import DrawerFor
from tracer.session.request import Request, Workers


@contextmanager
def open_workers(cluster: Any) -> Iterator[Workers]:
    """Yield a function that lets workers draw what a request asks for. Raises the errors of ``open_connection``."""
    with open_connection(plain(cluster)) as connection:

        def workers(request: Request, scene_hash: str) -> DrawerFor:
            loaded = isinstance(request.scene, LoadedScene)
            scene, define = (request.scene.path, request.scene.define) if loaded else (request.scene, request.define)
            view_fields = {"integrator": request.integrator, "size": request.size, "crop": request.crop}
            setup = make_setup(scene, scene_hash, mi.variant(), define, request.sensor, **view_fields)
            connection.begin(setup)
            return partial(RoundScheduler, connection, setup)

        yield workers
