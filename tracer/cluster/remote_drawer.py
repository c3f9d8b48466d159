"""From workers to a drawer for the loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import mitsuba as mi

from tracer.cluster.connection import open_crew
from tracer.cluster.round_scheduler import Spread
from tracer.cluster.worker_setup import make_setup
from tracer.session.terms import DrawerFor

Hire = Callable[..., DrawerFor]
"""From scene, hash of it, values of its $parameters, sensor and how it is seen to a drawer; see ``make_setup``."""


@contextmanager
def hire(cluster: Any) -> Iterator[Hire]:
    """Yield a function that lets workers draw a scene; see ``open_crew`` for ``cluster`` and errors."""
    with open_crew(cluster) as crew:

        def drawer(scene: Any, scene_hash: str, define: dict[str, str] | None, sensor: Any, **seen: Any) -> DrawerFor:
            setup = make_setup(scene, scene_hash, mi.variant(), define, sensor, **seen)
            crew.begin(setup)
            return partial(Spread, crew, setup)

        yield drawer
