"""How a measure is found by name, and what it needs to see.

All are listed in X. Bonaventura, M. Feixas, M. Sbert, L. Chuang and C. Wallraven, "A survey of viewpoint selection
methods for polygonal models", Entropy 20(5):370, 2018, which says who proposed which.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Literal

from tracer.errors import SettingsError
from tracer.viewpoint.observation import Sight

Best = Literal["most", "least"]
Need = Literal["picture", "channel", "saliency", "neighbours", "vertices", "areas"]
"""What else than areas: the view as an image, sums over all views, those of pairs of surfaces too, the views beside it,
vertices of meshes, true areas."""


@dataclass(frozen=True)
class Measure:
    """A named function from a view to a number."""

    name: str
    value: Callable[[Sight], float]
    best: Best
    """Which views are good: those of the most or the least."""
    needs: tuple[Need, ...]


registered: dict[str, Measure] = {}


def measure(name: str, best: Best, *needs: Need) -> Callable[[Callable[[Sight], float]], Callable[[Sight], float]]:
    """Register the decorated function as measure ``name``."""

    def register(function: Callable[[Sight], float]) -> Callable[[Sight], float]:
        registered[name] = Measure(name, function, best, needs)
        return function

    return register


@cache
def import_all() -> None:
    """Import every module of the folder, so that its measures are registered."""
    package = __name__.rpartition(".")[0]
    for module in pkgutil.iter_modules(importlib.import_module(package).__path__):
        importlib.import_module(f"{package}.{module.name}")


def names() -> list[str]:
    """Return the names of all measures."""
    import_all()
    return sorted(registered)


def get(name: str) -> Measure:
    """Return a measure by name. Raises SettingsError."""
    import_all()
    if name not in registered:
        raise SettingsError(f"Unknown measure '{name}'; choose one of {', '.join(names())}.")
    return registered[name]
