"""What a criterion is given, and the register in which it is found by name."""

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
    """Function that returns the complexity of what pilot rays hit; it traces them when it is first called."""
    statistics: Statistics | None
    """Statistics of the radiance samples so far; None for a criterion that decides before there are any."""
    before: Statistics | None
    """Statistics before the last round, without what that round added to ``statistics``; None if it was the first."""
    weight: Floats
    """Weight w of the objective, see ``tracer.image.objective``; ones before there are radiance samples."""
    weight_before: Floats | None
    """Weight w of the objective before the last round; None where ``before`` is."""
    colour_channels: int
    """How many channels of ``statistics``, from the first, are colour."""
    wanted: Floats
    """Weights >= 0 of what the person wants more of, by which importance is multiplied; ones unless any are given."""
    memory: dict[str, Any] = field(default_factory=dict)
    """Things that the criterion keeps for the next round of the same render, to save time. It is empty when a render
    goes on from a checkpoint, and the criterion must then decide the same."""

    @property
    def complexity(self) -> Complexity:
        """Complexity of what pilot rays hit; they are traced when this is first used."""
        return self.look()


Spends = Literal["share", "deviation", "more", "priority"]
"""How samples are allocated by importance. share: all samples are in proportion to it. deviation: as share, and the
importance is the standard deviation of a sample times sqrt(w), so that its cost can be weighed and the gain predicted.
more: the samples of the round are in proportion to it, whatever was drawn before. priority: the most important pixels
get as many samples again as they have, until the round is spent; a threshold that is lowered until the budget is spent
has the same effect."""


@dataclass(frozen=True)
class Criterion:
    """A named function from Evidence to importance, and what it needs to see."""

    name: str
    """Name by which a person chooses it."""
    importance: Callable[[Evidence], Floats]
    """Function from Evidence to the importance of each pixel (H, W), >= 0."""
    needs_radiance: bool
    """Whether it decides anew after every round of samples, rather than once from pilot rays alone."""
    spends: Spends
    """How samples are allocated by its importance."""
    moments: Moments | None = None
    """Function that computes the quantities of a sample whose mean or maximum over a pixel it needs; None: none."""

    @property
    def is_built_in(self) -> bool:
        """Whether it comes with tracer."""
        module = self.importance.__module__
        return module.startswith(f"{__name__.rpartition('.')[0]}.") and module != __name__


registered: dict[str, Criterion] = {}
"""Registered criteria by name."""
functions: dict[str, Criterion] = {}
"""Functions of callers that are not registered, by the name that ``name_of`` gave them."""


def criterion(
    name: str, *, needs_radiance: bool, spends: Spends = "share", moments: Moments | None = None
) -> Callable[[Callable[[Evidence], Floats]], Callable[[Evidence], Floats]]:
    """Register the decorated function as criterion ``name``. Raises ValueError if another file has the name."""

    def register(function: Callable[[Evidence], Floats]) -> Callable[[Evidence], Floats]:
        previous = registered.get(name)
        if previous is not None and inspect.getfile(previous.importance) != inspect.getfile(function):
            raise ValueError(f"there is a criterion '{name}' already; choose another name")
        registered[name] = Criterion(name, function, needs_radiance, spends, moments)
        return function

    return register


@cache
def import_all() -> None:
    """Import every module of this folder, so that its criteria are registered."""
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
    """Return the name by which ``get`` finds a criterion; anything but a function is returned as it is.

    A function that is not registered is taken to learn from radiance, and its importance to be the share of samples.
    """
    if not callable(criterion):
        return criterion
    import_all()
    registered_name = next((name for name, entry in registered.items() if entry.importance is criterion), None)
    if registered_name is not None:
        return registered_name
    name = f"function {getattr(criterion, '__qualname__', type(criterion).__qualname__)}"
    functions[name] = Criterion(name, checked(name, criterion), needs_radiance=True, spends="share")
    return name


def checked(name: str, function: Callable[[Evidence], Floats]) -> Callable[[Evidence], Floats]:
    """Return a caller's function that raises SettingsError if its result is no importance."""

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
    """Return how a message describes a value that is no importance."""
    if not is_numbers(values):
        return type(values).__name__
    wrong_count = np.count_nonzero(~(values >= 0))
    return f"of shape {values.shape}" + (f", {wrong_count} of them not >= 0" if wrong_count else "")


def is_function(name: str) -> bool:
    """Return whether ``name`` belongs to a caller's function that is not registered."""
    return name in functions


def names() -> list[str]:
    """Return the names of all registered criteria, sorted."""
    import_all()
    return sorted(registered)


def get(name: str) -> Criterion:
    """Return a criterion by name. Raises KeyError if there is none."""
    import_all()
    return functions[name] if name in functions else registered[name]
