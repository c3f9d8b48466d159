"""Metrics of a person's own in a study: functions of a picture and its reference."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from numpy.typing import ArrayLike

from tracer.core.arrays import Floats
from tracer.errors import SettingsError, StudyError
from tracer.image import metrics
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
