"""Names of the shapes of a scene for a person: the id in the scene file, the name in ``mi.traverse``, or a number.

A mesh without an id is called after its file, as in many public scenes. Numbers count from 1 in the order of
``scene.shapes()``, as in the layer ``shape.Y``. A shape within a group has the group's name before its own, as in
"tree.leaf". The name of the group stands for all shapes in it, and every instance of the group is a shape of its own.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

import mitsuba as mi

from tracer.core.suggest import did_you_mean
from tracer.errors import SettingsError

MOST_LISTED = 24
"""Most shapes whose names a message lists."""
UNNAMED = ("", "bsdf", "mesh_bsdf")
"""Ids of materials that say nothing: none, and those that Mitsuba takes from where a material stands."""
MERGED = "Mesh"
"""Class of the shape that Mitsuba makes when it merges several meshes of one material."""
HOW_TO_TELL_APART = " Meshes that Mitsuba has merged keep their names in a scene loaded with optimize=False."
"""Sentence at the end of a message about a scene with merged meshes."""


def name_after_files(nodes: Iterable[Any]) -> None:
    """Give each shape without an id the name of its file, before a scene is made of the nodes of a parser.

    ``models/Chair.ply`` is called ``Chair``, or ``Chair 2`` if something else has the name already.
    """
    nodes = list(nodes)
    taken = {node.props.id() for node in nodes}
    for node in nodes:
        file = node.props.get("filename")
        if node.type != mi.ObjectType.Shape or node.props.id() or not isinstance(file, str):
            continue
        stem = PurePath(file.replace("\\", "/")).stem.replace(".", "_")
        names = (stem if count == 1 else f"{stem} {count}" for count in itertools.count(1))
        name = next(name for name in names if name not in taken)
        node.props.set_id(name)
        taken.add(name)


@dataclass(frozen=True)
class Named:
    """A shape, or a group of shapes, with its names."""

    shapes: tuple[Any, ...]
    """The shapes that rays can hit: the shape itself, or those in the group."""
    names: frozenset[str]
    """Its id, and its name in ``mi.traverse``."""
    number: int | None
    """Number of the shape, from 1; None for a group and for a shape within a group."""
    label: str
    """How a message names it: by id, or else by number and place."""


def named_shapes(scene: Any) -> list[Named]:
    """Return all shapes of a scene with their names, and its groups with the shapes in them."""
    paths = shape_paths(scene)
    top_level = list(scene.shapes())
    named = [on_top_level(shape, number, paths.get(shape, "")) for number, shape in enumerate(top_level, 1)]
    for shape, path in paths.items():
        if shape not in top_level:
            members = tuple(member for member, member_path in paths.items() if member_path.startswith(f"{path}."))
            named.append(Named(members or (shape,), frozenset({path, shape.id()} - {""}), None, path))
    return named


def shape_paths(scene: Any) -> dict[Any, str]:
    """Return the name of every shape in ``mi.traverse``; within a group, after the group's name and a dot."""
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
    """Return a shape that is in no group, with its names; ``path``: its name in ``mi.traverse``, "" if it has none."""
    return Named((shape,), frozenset({shape.id(), path} - {""}), number, label_of(shape, number))


def label_of(shape: Any, number: int) -> str:
    """Return how a person is told of a shape: by its id, or else by its number, its class and its place."""
    centre = ", ".join(f"{coordinate:.3g}" for coordinate in shape.bbox().center())
    return shape.id() or f"{number} ({shape.class_name()} around {centre})"


def material_name(bsdf: Any) -> str:
    """Return the name that a scene gives a material, "" if it gives none: then Mitsuba calls it by its place."""
    name = bsdf.id() if bsdf is not None else ""
    return "" if name in UNNAMED else name


def find_shapes(scene: Any, names: list[str]) -> dict[str, list[Any]]:
    """Return the shapes that each of ``names`` stands for; ids take precedence over numbers. Raises SettingsError."""
    named = named_shapes(scene)
    matches = {
        name: [entry for entry in named if name in entry.names]
        or [entry for entry in named if name == str(entry.number)]
        for name in names
    }
    unknown = next((name for name, entries in matches.items() if not entries), None)
    if unknown is not None:
        raise SettingsError(f"shape_weights: the scene has no shape '{unknown}'{what_there_is(unknown, named)}")
    return {name: [shape for entry in entries for shape in entry.shapes] for name, entries in matches.items()}


def what_there_is(name: str, named: list[Named]) -> str:
    """Return the end of a message about an unknown name: the nearest name, or else all that there are."""
    if hint := did_you_mean(name, [known_name for entry in named for known_name in entry.names], otherwise=""):
        return hint
    if not named:
        return ", nor any other."
    more = f" and {len(named) - MOST_LISTED} more" if len(named) > MOST_LISTED else ""
    has_merged = any(shape.class_name() == MERGED and not shape.id() for entry in named for shape in entry.shapes)
    return f"; it has {'; '.join(entry.label for entry in named[:MOST_LISTED])}{more}.{HOW_TO_TELL_APART * has_merged}"
