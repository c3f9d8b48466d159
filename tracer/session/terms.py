"""How a render is carried out: who is told of it, what is kept of it, who draws it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tracer import criteria
from tracer.progress import ProgressCallback
from tracer.scene.view import View
from tracer.session.checkpoint import Keeper
from tracer.session.local_drawer import Drawer

DrawerFor = Callable[[View, criteria.Criterion, int], Drawer]
"""From a view, the criterion that decides and the most samples of a pass to who draws."""


@dataclass(frozen=True)
class Terms:
    """How a render is carried out, which changes none of its samples; see ``tracer.render``."""

    progress: ProgressCallback | None = None
    keeper: Keeper | None = None
    """Has the state of an earlier render to go on from, and keeps that of this one."""
    started: float | None = None
    memory_limit: float | None = None
    features: bool = False
    denoise: bool = False
    drawer: DrawerFor | None = None
    """Draws elsewhere than in this process."""


PLAIN = Terms()
"""Nobody is told of it, nothing is kept of it, and this process draws it."""
