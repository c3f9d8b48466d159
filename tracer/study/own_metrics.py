"""Metrics of a person's own in a study: functions of a picture and its reference."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping

from numpy.typing import ArrayLike

from tracer.core.arrays import Floats
from tracer.core.own_code import run_file
from tracer.errors import SettingsError, StudyError
from tracer.image import metrics
from tracer.study.plan import Plan
from tracer.study.records import SCORES

Metric = Callable[[Floats, Floats], float]
"""Function of a picture and its reference, both (H, W, 3), float64, in linear sRGB, to one number."""
TAKEN = {
    *SCORES,
    "scene",
    "method",
    "budget",
    "seed",
    "spp",
    "samples",
    "seconds",
    "seconds_drawing",
    "run",
    "machine",
    "too_close",
}
"""Names that the columns of ``results.csv`` have already."""


def metrics_of(plan: Plan) -> dict[str, Metric]:
    """Return the metrics in the Python files that a plan names: all functions in them whose name has no leading "_".

    Raises SettingsError, with the line of the plan, for a file that is missing or fails, or that has no such function.
    """
    own: dict[str, Metric] = {}
    for k, name in enumerate(plan.metrics):
        path = plan.base / name
        try:
            module = run_file(path, "metrics")
            functions = dict(inspect.getmembers(module, inspect.isfunction))
            found = {
                word: function
                for word, function in functions.items()
                if word[0] != "_" and function.__module__ == module.__name__
            }
            if not found:
                raise SettingsError(f"'{path}' has no function; write def worst(picture, reference): ...")
            check_metrics(found)
            if twice := own.keys() & found.keys():
                raise SettingsError(f"metrics: '{min(twice)}' is in two files; choose another name.")
        except SettingsError as error:
            raise plan.origin.fault(str(error), ("metrics", k), name) from None
        own |= found
    return own


def check_metrics(own: Mapping[str, Metric]) -> None:
    """Raise SettingsError for a metric that is no function, or whose name another column of the results has."""
    for name, metric in own.items():
        if name in TAKEN or not name.isidentifier():
            reason = "is the name of another column" if name in TAKEN else "is no name of letters, digits and _"
            raise SettingsError(f"metrics: '{name}' {reason}; choose another name.")
        if not callable(metric):
            raise SettingsError(f"metrics: '{name}' must be a function of picture and reference (was {metric!r}).")


def values_of(own: Mapping[str, Metric], image: ArrayLike, reference: ArrayLike) -> dict[str, float]:
    """Return the values of a person's metrics by name. Raises StudyError, which names the metric, if one fails."""
    picture, truth = metrics.comparable(image, reference)
    values = {}
    for name, metric in own.items():
        try:
            values[name] = float(metric(picture, truth))
        except Exception as error:  # a person's function may raise anything
            raise StudyError(f"The metric '{name}' failed: {type(error).__name__}: {error}.") from error
    return values
