"""How much each surface counts in a view: what a person says of it, and how well light shows it.

A weight of 0 leaves a surface out of what counts; it still hides what lies behind it. The paper, section 5, asks for
the semantics of a scene in this form, and leaves open in section 2 what light has to do with complexity.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import compress

import numpy as np
from numpy.typing import NDArray

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

    A surface has its own name and those of its shapes, see ``named``. Of several patterns that match, the last counts.
    Raises SettingsError for a pattern that matches nothing, or a part of a surface, or if nothing counts any more.
    """
    values = np.ones(subject.count)
    for pattern, weight in weights.items():
        values[named(subject, pattern)] = weight
    return with_weights(subject, subject.weights * values)


def named(subject: Subject, pattern: str) -> NDArray[np.bool_]:
    """Return which surfaces (Z,) a pattern names: by their own names, or by those of all shapes that they are made of.

    Raises SettingsError for a pattern that matches no name, or only some of the shapes of a surface.
    """
    known = sorted({*subject.names, *subject.shape_names})
    matches = set(compress(known, matching(pattern, known)))
    by_name = np.array([name in matches for name in subject.names] or [False] * subject.count)
    if not subject.shape_names:
        return by_name
    sides = 2 if subject.has_sides else 1
    count = subject.count // sides
    faces = int(subject.face_counts.sum())
    surface = np.arange(faces) if subject.surface_of_face is None else np.array(subject.surface_of_face, np.int64)
    is_of_shape = np.repeat([name in matches for name in subject.shape_names], subject.face_counts)
    totals, matched = (np.bincount(part, minlength=count + 1)[:count] for part in (surface, surface[is_of_shape]))
    some, whole = (np.repeat(chosen, sides) for chosen in (matched > 0, (matched > 0) & (matched == totals)))
    partly = np.flatnonzero(some & ~whole & ~by_name)
    if len(partly):
        name = subject.names[partly[0]]
        raise SettingsError(
            f"'{pattern}' matches some of the shapes of the surface '{name}', and a surface counts as a whole: weigh "
            f"'{name}', or choose other surfaces."
        )
    return np.asarray(by_name | whole)


def with_weights(subject: Subject, weights: Floats) -> Subject:
    """Return a subject with other ``weights`` (Z,). Raises SettingsError if all of them are 0."""
    if not np.any(weights > 0):
        raise SettingsError("Nothing counts: all weights are 0.")
    return replace(subject, weights=weights)
