"""From workers to a drawer for the loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import mitsuba as mi

from tracer.cluster.connection import open_connection
from tracer.cluster.round_scheduler import RoundScheduler
from tracer.cluster.worker_setup import make_setup
from tracer.session.terms import DrawerFor

RemoteDrawer = Callable[..., DrawerFor]
"""From scene, hash of it, values of its $parameters, sensor and how it is seen to who draws it; see ``make_setup``."""


@contextmanager
def open_remote_drawer(cluster: Any) -> Iterator[RemoteDrawer]:
    """Yield a function that lets workers draw a scene; see ``open_connection`` for ``cluster`` and errors."""
    with open_connection(cluster) as connection:

        def drawer(scene: Any, scene_hash: str, define: dict[str, str] | None, sensor: Any, **seen: Any) -> DrawerFor:
            setup = make_setup(scene, scene_hash, mi.variant(), define, sensor, **seen)
            connection.begin(setup)
            return partial(RoundScheduler, connection, setup)

        yield drawer
