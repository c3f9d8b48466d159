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
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from tracer.core.arrays import Floats
from tracer.errors import SettingsError

if TYPE_CHECKING:
    from tracer.complexity.pilot import Complexity
    from tracer.film.estimate import Statistics
    from tracer.sampling.samples import Moments


@dataclass(frozen=True)
class Evidence:
    """All that is known when an allocation is made. Arrays are (height, width) of the pixels that are sampled."""

    look: Callable[[], Complexity]
    """Traces the pilot rays, the first time it is called."""
    statistics: Statistics | None
    """Of the radiance samples so far; None for a criterion that decides before there are any."""
    before: Statistics | None
    """The same before the last round: what is in ``statistics`` beyond it was not yet seen then."""
    weight: Floats
    """w of the objective, see ``tracer.image.objective``; ones before there are radiance samples."""
    weight_before: Floats | None
    """The same as it was known ``before``."""
    colour_channels: int
    """How many channels of ``statistics``, from the first, are colour."""
    wanted: Floats
    """What the person wants more of, >= 0: importance is multiplied by it. Ones unless there is a mask or weight."""
    memory: dict[str, Any] = field(default_factory=dict)
    """What the criterion wants to find again in the next round of the same render, to save time: a render that goes on
    from a checkpoint begins with none, and must decide the same."""

    @property
    def complexity(self) -> Complexity:
        """Of what pilot rays hit; they are traced when this is first asked for."""
        return self.look()


Spends = Literal["share", "deviation", "more", "priority"]
"""share: samples in proportion to importance. deviation: the same, and importance is the standard deviation of a sample
times sqrt(w), so that its cost can be weighed and the gain predicted. more: samples beyond those drawn in proportion to
importance. priority: pixels of most importance get as many again as they have, until the round is spent: what a
threshold does that is lowered until the budget is spent."""


@dataclass(frozen=True)
class Criterion:
    """A named function from Evidence to importance, and what it needs to see."""

    name: str
    importance: Callable[[Evidence], Floats]
    needs_radiance: bool
    """Whether it decides anew after every round of samples, rather than once from pilot rays alone."""
    spends: Spends
    """What is done with its importance."""
    moments: Moments | None = None
    """Quantities of a sample whose mean or maximum over a pixel it wants to see in ``Statistics``."""


registered: dict[str, Criterion] = {}
functions: dict[str, Criterion] = {}
"""Of callers, that are not registered, by the name that ``name_of`` gave them."""


def criterion(
    name: str, *, needs_radiance: bool, spends: Spends = "share", moments: Moments | None = None
) -> Callable[[Callable[[Evidence], Floats]], Callable[[Evidence], Floats]]:
    """Register the decorated function as criterion ``name``. Raises ValueError if another file has that name."""

    def register(function: Callable[[Evidence], Floats]) -> Callable[[Evidence], Floats]:
        before = registered.get(name)
        if before is not None and inspect.getfile(before.importance) != inspect.getfile(function):
            raise ValueError(f"there is a criterion '{name}' already; choose another name")
        registered[name] = Criterion(name, function, needs_radiance, spends, moments)
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
    from tracer.core.threads import for_files

    import_all()
    specification = importlib.util.spec_from_file_location(f"tracer_criteria_{path.stem}", path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[specification.name] = module  # where dataclasses look for it
    with for_files():
        specification.loader.exec_module(module)


def name_of(criterion: Any) -> Any:
    """Return the name by which ``get`` finds a criterion; one that is a name already, or is none, is passed through.

    A function that is not registered is taken to learn from radiance, and its importance to be the share of samples.
    """
    if not callable(criterion):
        return criterion
    import_all()
    known = next((name for name, entry in registered.items() if entry.importance is criterion), None)
    if known is not None:
        return known
    name = f"function {getattr(criterion, '__qualname__', type(criterion).__qualname__)}"
    functions[name] = Criterion(name, checked(name, criterion), needs_radiance=True, spends="share")
    return name


def checked(name: str, function: Callable[[Evidence], Floats]) -> Callable[[Evidence], Floats]:
    """Return a function of a caller that raises SettingsError if what it returns is no importance."""

    def importance(evidence: Evidence) -> Floats:
        values, shape = function(evidence), evidence.wanted.shape
        if not (is_numbers(values) and values.shape == shape and np.all(values >= 0)):
            raise SettingsError(
                f"criterion: {name} must return an importance >= 0 for every pixel, an array of shape {shape} "
                f"(was {described(values)})."
            )
        return values.astype(np.float64)

    return importance


def is_numbers(values: Any) -> bool:
    """Return whether a value is an array of numbers."""
    return isinstance(values, np.ndarray) and values.dtype.kind in "buif"


def described(values: Any) -> str:
    """Return what a message says of a value that is no importance."""
    if not is_numbers(values):
        return type(values).__name__
    wrong = np.count_nonzero(~(values >= 0))
    return f"of shape {values.shape}" + (f", {wrong} of them not >= 0" if wrong else "")


def is_function(name: str) -> bool:
    """Return whether ``name`` is that of a function that is not registered."""
    return name in functions


def names() -> list[str]:
    """Return the names of all criteria."""
    import_all()
    return sorted(registered)


def get(name: str) -> Criterion:
    """Return a criterion by name. Raises KeyError."""
    import_all()
    return functions[name] if name in functions else registered[name]
