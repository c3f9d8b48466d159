"""What a person calls the shapes of a scene: by the id in the scene file, by the name in ``mi.traverse``, by number.

Numbers count from 1 in the order of ``scene.shapes()``, as in the layer ``shape.Y``. What is within a group has the
name of the group before its own, as in "tree.leaf"; the name of the group itself is all that is in it, and every
instance of it is a shape of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mitsuba as mi

from tracer.core.suggest import did_you_mean
from tracer.errors import SettingsError

MOST_LISTED = 24
"""Names in a message."""
MERGED = "Mesh"
"""What Mitsuba makes of several meshes of one material."""
HOW_TO_TELL_APART = " Meshes that Mitsuba has merged keep their names in a scene loaded with optimize=False."


@dataclass(frozen=True)
class Named:
    """One shape, or a group of them, and what it is called."""

    shapes: tuple[Any, ...]
    """What rays hit of it."""
    names: frozenset[str]
    """Its id, and what ``mi.traverse`` calls it."""
    number: int | None
    """None within a group."""
    label: str
    """How a message names it: by id, else by number with where it is."""


def named_shapes(scene: Any) -> list[Named]:
    """Return all shapes of a scene, and its groups with what is in them."""
    paths = shape_paths(scene)
    on_top = list(scene.shapes())
    named = [on_top_level(shape, number, paths.get(shape, "")) for number, shape in enumerate(on_top, 1)]
    for shape, path in paths.items():
        if shape not in on_top:
            members = tuple(member for member, other in paths.items() if other.startswith(f"{path}."))
            named.append(Named(members or (shape,), frozenset({path, shape.id()} - {""}), None, path))
    return named


def shape_paths(scene: Any) -> dict[Any, str]:
    """Return the name of every shape, as ``mi.traverse`` has it: those of a group after the group's and a dot."""
    paths: dict[Any, str] = {}

    class Walk(mi.TraversalCallback):  # Mitsuba has the class only when a variant is set
        def __init__(self, prefix: str) -> None:
            super().__init__()
            self.prefix = prefix

        def put(self, name: str, value: Any, *rest: Any) -> None:
            if isinstance(value, mi.Shape) and value not in paths:
                paths[value] = self.prefix + name
                value.traverse(Walk(f"{self.prefix}{name}."))

    scene.traverse(Walk(""))
    return paths


def on_top_level(shape: Any, number: int, path: str) -> Named:
    """Return a shape that is in no group."""
    centre = ", ".join(f"{coordinate:.3g}" for coordinate in shape.bbox().center())
    label = shape.id() or f"{number} ({shape.class_name()} around {centre})"
    return Named((shape,), frozenset({shape.id(), path} - {""}), number, label)


def find_shapes(scene: Any, wanted: list[str]) -> dict[str, list[Any]]:
    """Return the shapes that have each of the names ``wanted``; ids go before numbers. Raises SettingsError."""
    named = named_shapes(scene)
    found = {
        name: [entry for entry in named if name in entry.names]
        or [entry for entry in named if name == str(entry.number)]
        for name in wanted
    }
    unknown = next((name for name, entries in found.items() if not entries), None)
    if unknown is not None:
        raise SettingsError(f"shape_weights: the scene has no shape '{unknown}'{what_there_is(unknown, named)}")
    return {name: [shape for entry in entries for shape in entry.shapes] for name, entries in found.items()}


def what_there_is(name: str, named: list[Named]) -> str:
    """Return the end of a message: the name that is nearest, else all that there are."""
    if hint := did_you_mean(name, [other for entry in named for other in entry.names], otherwise=""):
        return hint
    if not named:
        return ", nor any other."
    more = f" and {len(named) - MOST_LISTED} more" if len(named) > MOST_LISTED else ""
    merged = any(shape.class_name() == MERGED and not shape.id() for entry in named for shape in entry.shapes)
    return f"; it has {'; '.join(entry.label for entry in named[:MOST_LISTED])}{more}.{HOW_TO_TELL_APART * merged}"
