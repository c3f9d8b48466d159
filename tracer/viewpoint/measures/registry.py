"""How a measure is found by its name, and what it needs to be given.

All are listed in X. Bonaventura, M. Feixas, M. Sbert, L. Chuang and C. Wallraven, "A survey of viewpoint selection
methods for polygonal models", Entropy 20(5):370, 2018, which says who proposed each measure.
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
"""Good views have the most or the least of a measure."""
Need = Literal["picture", "channel", "saliency", "neighbours", "vertices", "areas"]
"""A measure may need these besides the projected areas of a view: the view as an image, sums over all views (the
channel), also sums of pairs of surfaces (for saliency), the views beside it, the vertices it sees, true areas."""


@dataclass(frozen=True)
class Measure:
    """A named function from a view to a number."""

    name: str
    value: Callable[[Sight], float]
    best: Best
    """Whether good views have the most or the least of it."""
    needs: tuple[Need, ...]
    """What it needs besides the projected areas of a view."""


registered: dict[str, Measure] = {}
"""This holds the measures by name, of all modules that have been imported."""


def measure(name: str, best: Best, *needs: Need) -> Callable[[Callable[[Sight], float]], Callable[[Sight], float]]:
    """Return a decorator that registers a function as the measure ``name``."""

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
    """Return the names of all measures in alphabetical order.

    Example:

    >>> from tracer.viewpoint import measures
    >>> "entropy" in measures.names()
    True
    """
    import_all()
    return sorted(registered)


def get(name: str) -> Measure:
    """Return the measure ``name``. Raises SettingsError if there is none."""
    import_all()
    if name not in registered:
        raise SettingsError(f"Unknown measure '{name}'; choose one of {', '.join(names())}.")
    return registered[name]
