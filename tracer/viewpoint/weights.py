"""How much each surface counts in a view: what a person says of it, and how well light shows it.

A weight of 0 leaves a surface out of what counts; it still hides what lies behind it. The paper, section 5, asks for
the semantics of a scene in this form, and leaves open in section 2 what light has to do with complexity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tracer.core.arrays import Floats
from tracer.errors import SettingsError
from tracer.viewpoint.grouping import matching
from tracer.viewpoint.surfaces import Subject

MOST = 1e6
"""Largest weight."""


def weights_from_text(texts: Sequence[str]) -> dict[str, float]:
    """Return weights by pattern from texts such as ``lamp*=5``. Raises SettingsError for any other text."""
    weights = {}
    for text in texts:
        pattern, _, number = text.rpartition("=")
        try:
            weight = float(number)
        except ValueError:
            weight = np.nan
        if not pattern.strip() or not 0 <= weight <= MOST:
            raise SettingsError(
                f"A weight is a name or pattern and a number from 0 to {MOST:g}, such as lamp*=5, not '{text}'."
            )
        weights[pattern.strip()] = weight
    return weights


def weighted(subject: Subject, weights: Mapping[str, float]) -> Subject:
    """Return a subject whose surfaces count as much as the patterns say that match their names, and 1 otherwise.

    Faces have the names of their shapes. Of several patterns that match, the last counts. Raises SettingsError for a
    pattern that matches nothing, or if nothing counts any more.
    """
    names = subject.names or subject.shape_names
    by_name = np.ones(len(names))
    for pattern, weight in weights.items():
        by_name[matching(pattern, names)] = weight
    values = by_name if subject.names else np.repeat(by_name, subject.face_counts)
    return with_weights(subject, subject.weights * values)


def with_weights(subject: Subject, weights: Floats) -> Subject:
    """Return a subject with other ``weights`` (Z,). Raises SettingsError if all of them are 0."""
    if not np.any(weights > 0):
        raise SettingsError("Nothing counts: all weights are 0.")
    return replace(subject, weights=weights)
