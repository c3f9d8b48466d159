"""What a criterion is given, and how it is found by name."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tracer.estimate import Statistics
    from tracer.pilot import Complexity

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Evidence:
    """All that is known when an allocation is made. Arrays are (height, width) of the pixels that are sampled."""

    complexity: Complexity | None
    """Of what pilot rays hit; None for a criterion that needs no pilot."""
    statistics: Statistics | None
    """Of the radiance samples so far; None for a criterion that decides before there are any."""
    before: Statistics | None
    """The same before the last round: what is in ``statistics`` beyond it was not yet seen then."""
    weight: Floats
    """w of the objective, see ``tracer.objective``; ones before there are radiance samples."""
    colour_channels: int
    """How many channels of ``statistics``, from the first, are colour."""
    goal: int
    """Samples that the allocation will share out, those already drawn included."""
    memory: dict[str, Any] = field(default_factory=dict)
    """What the criterion wants to find again in the next round of the same render."""


@dataclass(frozen=True)
class Criterion:
    """A named function from Evidence to importance, and what it needs to see."""

    name: str
    importance: Callable[[Evidence], Floats]
    needs_radiance: bool
    """Whether it decides anew after every round of samples, rather than once from pilot rays alone."""
    needs_pilot: bool


registered: dict[str, Criterion] = {}


def criterion(
    name: str, *, needs_radiance: bool, needs_pilot: bool = True
) -> Callable[[Callable[[Evidence], Floats]], Callable[[Evidence], Floats]]:
    """Register the decorated function as criterion ``name``. Raises ValueError if another file has that name."""

    def register(function: Callable[[Evidence], Floats]) -> Callable[[Evidence], Floats]:
        before = registered.get(name)
        if before is not None and inspect.getfile(before.importance) != inspect.getfile(function):
            raise ValueError(f"there is a criterion '{name}' already; choose another name")
        registered[name] = Criterion(name, function, needs_radiance, needs_pilot)
        return function

    return register


@cache
def import_all() -> None:
    """Import every module of the folder, so that its criteria are registered."""
    package = __name__.rpartition(".")[0]
    for module in pkgutil.iter_modules(importlib.import_module(package).__path__):
        importlib.import_module(f"{package}.{module.name}")


def import_file(path: Path) -> None:
    """Run a Python file that registers criteria of its own. Raises whatever it raises."""
    import_all()
    specification = importlib.util.spec_from_file_location(f"tracer_criteria_{path.stem}", path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[specification.name] = module  # where dataclasses look for it
    specification.loader.exec_module(module)


def names() -> list[str]:
    """Return the names of all criteria."""
    import_all()
    return sorted(registered)


def get(name: str) -> Criterion:
    """Return a criterion by name. Raises KeyError."""
    import_all()
    return registered[name]
