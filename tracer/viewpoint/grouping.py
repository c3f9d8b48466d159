"""Which faces count as one surface: by face, shape, material, the names of shapes, or an attribute of meshes."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Any, Literal, get_args

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Integers
from tracer.core.suggest import did_you_mean
from tracer.errors import SettingsError
from tracer.scene.shape_names import MOST_LISTED

Surfaces = Literal["face", "shape", "bsdf"]
"""These kinds of surface can be chosen by name."""
SURFACES: tuple[str, ...] = get_args(Surfaces)
"""These are the names of the kinds of surface."""
ATTRIBUTES = ("face_", "vertex_")
"""Names of attributes of meshes begin like this, in Mitsuba and here."""
WITHOUT = "without"
"""Name of the surface of all faces that do not have the attribute by which others are told apart."""


def number_surfaces(
    shapes: list[Any], counts: Integers, surfaces: str, patterns: Sequence[str] = ()
) -> tuple[Integers, list[str]]:
    """Return the surface of every face (F,), and the names of the surfaces, none if they are faces.

    ``counts``: number of faces of each shape. ``surfaces``: one of SURFACES, or the name of an attribute of meshes.
    ``patterns``: all shapes whose names match a pattern, such as ``chair*``, are one surface, whatever ``surfaces`` is;
    of several patterns the first counts. Raises SettingsError for a kind of surface that does not exist, an attribute
    that no mesh has, and a pattern that no shape matches.
    """
    if surfaces.startswith(ATTRIBUTES):
        labels, names = by_attribute(shapes, counts, surfaces)
    elif surfaces in SURFACES:
        labels, names = by_kind(shapes, counts, surfaces)
    else:
        raise SettingsError(
            f"Unknown kind of surface '{surfaces}'; choose one of {', '.join(SURFACES)}, or an attribute of meshes, "
            "whose name begins with face_ or vertex_."
        )
    return grouped(shapes, counts, labels, names, patterns) if patterns else (labels, names)


def names_of(shapes: Sequence[Any]) -> list[str]:
    """Return the id of each shape in the scene file, or if it has none its number, from 1."""
    return [shape.id() or str(number) for number, shape in enumerate(shapes, 1)]


def by_kind(shapes: list[Any], counts: Integers, surfaces: str) -> tuple[Integers, list[str]]:
    """Return the surface of every face, and the names of the surfaces, for one of SURFACES."""
    if surfaces == "face":
        return np.arange(counts.sum()), []
    if surfaces == "shape":
        return np.repeat(np.arange(len(shapes)), counts), names_of(shapes)
    owners = [shape.bsdf() for shape in shapes]
    keys: dict[int, int] = {}
    numbers = [keys.setdefault(id(owner) if owner is not None else 0, len(keys)) for owner in owners]
    names = [""] * len(keys)
    for owner, k in zip(owners, numbers, strict=True):
        names[k] = owner.id() if owner is not None else "no bsdf"
    return np.repeat(numbers, counts), names


def by_attribute(shapes: list[Any], counts: Integers, attribute: str) -> tuple[Integers, list[str]]:
    """Return the surface of every face, and the names of the surfaces: faces of equal values are one surface."""
    values = [face_values(shape, attribute) if has_attribute(shape, attribute) else None for shape in shapes]
    width = max((value.shape[1] for value in values if value is not None), default=0)
    if width == 0:
        raise SettingsError(f"No mesh has an attribute '{attribute}'; {attributes_in_words(shapes)}.")
    rows = [
        np.full((count, width), np.nan) if value is None else np.pad(value, ((0, 0), (0, width - value.shape[1])))
        for value, count in zip(values, counts, strict=True)
    ]
    different, labels = np.unique(np.concatenate(rows), axis=0, return_inverse=True, equal_nan=False)
    # Rows without a value are all different from each other, as NaN is from itself.
    is_known = ~np.isnan(different).any(axis=1)
    numbers = np.where(is_known, np.cumsum(is_known) - 1, is_known.sum())
    names = [f"{attribute} {' '.join(f'{number:g}' for number in row)}" for row in different[is_known]]
    return numbers[labels.reshape(-1)], [*names, *([] if is_known.all() else [WITHOUT])]


def has_attribute(shape: Any, attribute: str) -> bool:
    """Return whether a shape is a mesh with an attribute of this name."""
    return bool(shape.is_mesh() and shape.has_attribute(attribute))


def face_values(mesh: Any, attribute: str) -> NDArray[np.float64]:
    """Return the values (faces, D) of an attribute: of a vertex attribute, what two corners share, else the first's."""
    values = np.array(mesh.attribute_buffer(attribute), np.float64)
    if attribute.startswith("face_"):
        return values.reshape(mesh.face_count(), -1)
    faces = np.array(mesh.faces_buffer(), np.int64).reshape(-1, 3)
    first, second, third = values.reshape(mesh.vertex_count(), -1)[faces].transpose(1, 0, 2)
    return np.where(np.all(second == third, axis=1, keepdims=True), second, first)


def attributes_in_words(shapes: list[Any]) -> str:
    """Return a clause that lists the attributes of meshes."""
    known = sorted({name for shape in shapes if shape.is_mesh() for name in attribute_names(shape)})
    return f"there are {', '.join(known)}" if known else "there is none"


def attribute_names(mesh: Any) -> list[str]:
    """Return the names of the attributes of a mesh."""
    return [name for name in mi.traverse(mesh).keys() if name.startswith(ATTRIBUTES) and mesh.has_attribute(name)]  # noqa: SIM118


def grouped(
    shapes: list[Any], counts: Integers, labels: Integers, names: list[str], patterns: Sequence[str]
) -> tuple[Integers, list[str]]:
    """Return surfaces and names like ``labels`` and ``names``, with one surface for each pattern before all others.

    Faces that are surfaces have the names of their shapes.
    """
    shape_names = names_of(shapes)
    owner = np.full(len(shapes), -1)
    for number, pattern in reversed(list(enumerate(patterns))):
        matches = matching(pattern, shape_names)
        owner[matches] = number
    group = np.repeat(owner, counts)
    others, renumbered = np.unique(labels[group < 0], return_inverse=True)
    result = group.copy()
    result[group < 0] = renumbered + len(patterns)
    other_names = (
        [names[k] for k in others]
        if names
        else [shape_names[k] for k in np.repeat(np.arange(len(shapes)), counts)[others]]
    )
    return result, [*patterns, *other_names]


def matching(pattern: str, names: Sequence[str]) -> NDArray[np.bool_]:
    """Return which of the names (N,) match a pattern. Raises SettingsError if none does."""
    matches = np.array([fnmatchcase(name, pattern) for name in names], bool)
    if not matches.any():
        known = sorted(set(names), key=lambda name: (len(name) if name.isdecimal() else 0, name))  # numbers in order
        more = f" and {len(known) - MOST_LISTED} more" if len(known) > MOST_LISTED else ""
        listed = f"; there are {', '.join(known[:MOST_LISTED])}{more}."
        raise SettingsError(f"Nothing is called '{pattern}'{did_you_mean(pattern, known, otherwise=listed)}")
    return matches
