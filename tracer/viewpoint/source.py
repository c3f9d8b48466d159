"""Open a file that a person names as a subject: a Mitsuba scene, a mesh, a molecule or a crystal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from tracer.errors import SceneError, SettingsError
from tracer.scene import mesh_files
from tracer.scene.load import LOAD_ERRORS, load
from tracer.scene.load_errors import load_error
from tracer.scene.mesh_scene import shapes_of
from tracer.scene.parts import recentred
from tracer.scene.validate import require_faces
from tracer.viewpoint import atom_files
from tracer.viewpoint.atom_source import Shown, open_atoms, open_pair_of_atoms
from tracer.viewpoint.docking import Pair
from tracer.viewpoint.light import weighted_by_light
from tracer.viewpoint.opened import Opened
from tracer.viewpoint.surfaces import open_subject
from tracer.viewpoint.weights import weighted

SERIALIZED = ".serialized"
"""Suffix of Mitsuba's own mesh files, which it reads itself."""
UP_IS_Z = (".stl", ".3mf")
"""In mesh files with these suffixes z is usually the upward axis; in others it is y."""


@dataclass(frozen=True)
class Counted:
    """What counts as a surface, and how much."""

    surfaces: str | None = None
    """A kind of surface, or an attribute of meshes, see ``number_surfaces``; None: as usual."""
    groups: tuple[str, ...] = ()
    """Patterns of names of shapes; those that match one are one surface."""
    weights: Mapping[str, float] = field(default_factory=dict)
    """How much surfaces count, by patterns of their names; see ``tracer.viewpoint.weights``."""
    by_light: bool = False
    """Whether surfaces count as well as the scene's light shows them."""


def open_source(path: Path, counted: Counted | None = None, shown: Shown | None = None) -> Opened:
    """Return the subject that a file holds. Raises SceneError or SettingsError.

    Of a molecule the surfaces are the atoms, so that ``counted`` can have weights alone, by element.
    """
    counted, shown = counted or Counted(), shown or Shown()
    if path.suffix.lower() in atom_files.SUFFIXES:
        if counted.surfaces is not None or counted.groups or counted.by_light:
            raise SettingsError(
                f"The surfaces of a molecule are its atoms, without light: leave out 'surfaces', 'group' and "
                f"'by-light' for '{path}'."
            )
        opened = open_atoms(path, shown)
    elif shown != Shown():
        raise SettingsError(
            "Repeating, cutting, models, assemblies, style, bonds and the radius of atoms are for molecules, and "
            f"'{path}' is none."
        )
    else:
        opened = open_scene_file(path, counted)
    subject = weighted(opened.subject, counted.weights) if counted.weights else opened.subject
    return replace(opened, subject=weighted_by_light(subject) if counted.by_light else subject)


def open_scene_file(path: Path, counted: Counted) -> Opened:
    """Return the subject that a scene or a mesh file holds. Raises SceneError or SettingsError."""
    suffix = path.suffix.lower()
    kind = counted.surfaces or ("shape" if counted.groups else "face")
    if suffix in mesh_files.SUFFIXES:
        parts, (x, y, z) = recentred(mesh_files.read_parts(path))
        scene = mi.load_dict({"type": "scene", **shapes_of(parts)})
        origin = (float(x), float(y), float(z))
        return Opened(open_subject(scene, kind, patterns=counted.groups), up=up_of_file(path), origin=origin)
    if suffix == SERIALIZED:
        if not path.is_file():
            raise SceneError(f"There is no mesh '{path}'.")
        try:
            scene = mi.load_dict({"type": "scene", "mesh": {"type": "serialized", "filename": str(path.resolve())}})
        except LOAD_ERRORS as error:
            raise load_error(f"'{path}'", error) from None
        require_faces(f"'{path}'", scene)
    elif suffix == ".xml" or not path.suffix:
        scene = load(path)
        if scene.class_name() != "Scene":
            raise SceneError(f"'{path}' holds a {scene.class_name()}, not a scene; wrap it in <scene>.")
    else:
        suffixes = ", ".join([".xml", *mesh_files.SUFFIXES, SERIALIZED, *atom_files.SUFFIXES])
        raise SceneError(f"'{path}' is no scene, mesh or molecule by its name; its suffix must be one of {suffixes}.")
    return Opened(open_subject(scene, kind, patterns=counted.groups), up=upwards(scene))


def upwards(scene: Any) -> tuple[float, float, float]:
    """Return the axis, with its sign, nearest to the upward direction of the first camera; y if there is no camera."""
    if not scene.sensors():
        return (0.0, 1.0, 0.0)
    up = np.array(scene.sensors()[0].world_transform().matrix, np.float64).reshape(4, 4)[:3, 1]
    axis = np.zeros(3)
    axis[np.abs(up).argmax()] = np.sign(up[np.abs(up).argmax()])
    return (float(axis[0]), float(axis[1]), float(axis[2]))


def up_of_file(path: Path) -> tuple[float, float, float]:
    """Return the axis that usually points upwards in a mesh file of this name."""
    return (0.0, 0.0, 1.0) if path.suffix.lower() in UP_IS_Z else (0.0, 1.0, 0.0)


def open_pair_of_files(path: Path, other: Path, counted: Counted, shown: Shown) -> tuple[Opened, Pair]:
    """Return a molecule as it is seen from another one, and both; see ``tracer.viewpoint.docking``.

    The other one hides what lies behind it and does not count. Raises SceneError or SettingsError.
    """
    if counted.surfaces or counted.groups or counted.by_light:
        raise SettingsError("With --from, surfaces are atoms, without light: leave out surfaces, group, by-light.")
    opened, pair = open_pair_of_atoms(path, other, shown)
    if counted.weights:
        opened = replace(opened, subject=weighted(opened.subject, counted.weights))
    return opened, pair
