"""What a criterion is given, and the register in which it is found by name."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from tracer.core.arrays import Floats
from tracer.core.own_code import explaining
from tracer.errors import SettingsError

if TYPE_CHECKING:
    from tracer.complexity.pilot import Complexity
    from tracer.film.estimate import Statistics
    from tracer.sampling.samples import Moments


@dataclass(frozen=True)
class Evidence:
    """All that is known when an allocation is made: what a criterion is given.

    Arrays are (height, width) of the pixels that are sampled; these are a few more at each side than the picture has if
    its film samples its border.

    Example::

        import tracer
        from tracer.criteria import Evidence


        def noisy_edges(evidence: Evidence):
            deviation = evidence.statistics.variance.mean(axis=-1) ** 0.5
            return deviation * (1 + evidence.complexity.shape_entropy)


        tracer.render("scene.xml", spp=64, criterion=noisy_edges)
    """

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
"""How samples are allocated by importance.

"share": all samples are in proportion to it, those that are drawn already included. "deviation": as share, and the
importance is the standard deviation of a sample times sqrt(w), w being ``Evidence.weight``, so that its cost can be
weighed and the gain predicted: a render that would gain too little is uniform. "more": the samples of the round are in
proportion to it, whatever was drawn before. "priority": the most important pixels get as many samples again as they
have, until the round is spent; a threshold that is lowered until the budget is spent has the same effect.
"""


@dataclass(frozen=True)
class Criterion:
    """A named function from Evidence to importance, and what it needs to see.

    ``tracer.render`` takes one as ``criterion``, without its being registered.

    Example::

        import numpy as np
        import tracer
        from tracer.criteria import Criterion


        def edges(evidence):
            return 0.1 + np.sqrt(evidence.complexity.shape_gini)


        by_edges = Criterion("edges", edges, needs_radiance=False, spends="share")
        tracer.render("scene.xml", spp=64, criterion=by_edges)
    """

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

    def evaluate(self, evidence: Evidence) -> Floats:
        """Return the importance of each pixel (H, W).

        Raises SettingsError, in one sentence, if a person's criterion returns no importance, or if one from a file that
        was named fails, with the line; the failure of a function that was passed from Python is raised as it is.
        """
        if self.is_built_in:
            return np.asarray(self.importance(evidence), np.float64)
        if self.name not in files:
            values = self.importance(evidence)
        else:
            with explaining(files[self.name]):
                values = self.importance(evidence)
        return require_importance(self.name, values, evidence.wanted.shape)


registered: dict[str, Criterion] = {}
"""Registered criteria by name."""
functions: dict[str, Criterion] = {}
"""Criteria of callers that are not registered, by the name that ``name_of`` gave them."""
files: dict[str, Path] = {}
"""Files from which criteria were read, by the names of the criteria."""


def criterion(
    name: str, *, needs_radiance: bool, spends: Spends = "share", moments: Moments | None = None
) -> Callable[[Callable[[Evidence], Floats]], Callable[[Evidence], Floats]]:
    """Register the decorated function as criterion ``name``, by which renders and studies choose it.

    The function is given an ``Evidence`` and returns the importance of each pixel: an array of numbers >= 0 that has
    the shape (H, W) of ``evidence.wanted``.

    ``needs_radiance``: whether it looks at ``evidence.statistics``. If so, it decides anew before every round but the
    first, in which all pixels get the same. If not, it decides once, before the first sample, by what pilot rays have
    hit; ``evidence.statistics`` is then None.

    ``spends``: how samples are allocated by the importance, see ``Spends``. Choose "deviation" if the importance is a
    standard deviation, in whatever unit, and "share" else.

    ``moments``: function that says what else is to be remembered of samples. It is given the colour of a sample, a list
    with an ``mi.Float`` for each channel of colour, and the sample's index within its pixel, ``mi.UInt32``. It returns
    two lists of ``mi.Float``: of the first, ``evidence.statistics.moments`` (H, W, K) has the means, and of the second
    ``evidence.statistics.peaks`` the maxima.

    Raises ValueError if a criterion from another file has the name.

    Example::

        import numpy as np
        import tracer
        from tracer.criteria import criterion


        def brightest(colour, index):
            return [], [sum(colour)]


        @criterion("fireflies", needs_radiance=True, moments=brightest)
        def fireflies(evidence):
            mean = evidence.statistics.mean.sum(axis=-1)
            return np.maximum(evidence.statistics.peaks[..., 0], 0) / (mean + 0.1)


        tracer.render("scene.xml", spp=64, criterion="fireflies")
    """

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


def require_importance(name: str, values: Any, shape: tuple[int, ...]) -> Floats:
    """Return what a person's criterion returned, as float64. Raises SettingsError if it is no importance."""
    if not (is_numbers(values) and values.shape == shape and np.all(values >= 0)):
        raise SettingsError(
            f"criterion: {name} must return an importance >= 0 for every pixel, an array of shape {shape} "
            f"(was {described(values)})."
        )
    return values.astype(np.float64)


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
    """Return the names of all registered criteria, sorted.

    Example:

    >>> from tracer import criteria
    >>> criteria.names()[:3]
    ['chi_square', 'colour_contrast', 'contrast']
    """
    import_all()
    return sorted(registered)


def get(name: str) -> Criterion:
    """Return a criterion by name. Raises KeyError if there is none."""
    import_all()
    return functions[name] if name in functions else registered[name]
