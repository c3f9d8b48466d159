"""Open a file that a person names as a subject: a Mitsuba scene, a mesh, a molecule or a crystal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.core.extras import require_package
from tracer.errors import SceneError, SettingsError
from tracer.scene import mesh_files
from tracer.scene.load import LOAD_ERRORS, load
from tracer.scene.load_errors import load_error
from tracer.scene.mesh_scene import shapes_of
from tracer.scene.validate import require_faces
from tracer.viewpoint import atom_files, molecules
from tracer.viewpoint.docking import Pair, open_pair
from tracer.viewpoint.light import shown_by_light
from tracer.viewpoint.surfaces import Subject, open_subject
from tracer.viewpoint.weights import weighted, with_weights

SERIALIZED = ".serialized"
"""Suffix of Mitsuba's own mesh files, which it reads itself."""
UP_IS_Z = (".stl", ".3mf")
"""In mesh files with these suffixes z is usually the upward axis; in others it is y."""


@dataclass(frozen=True)
class Opened:
    """A subject, and how views of its kind are made."""

    subject: Subject
    colours: Floats | None = None
    """(Z, 3): colours of the surfaces in pictures, linear sRGB; None if the scene has its own."""
    orthographic: bool = False
    """Whether the subject is looked at with parallel rays, as molecules are."""
    axes: Floats | None = None
    """(N, 3): directions that a search should try, as atoms line up along them."""
    crystal: bool = False
    """Whether the subject is a part of a lattice."""
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Upward direction: the axis nearest to that of the scene's camera; for a mesh see ``up_of_file``."""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Place in the file of the origin of the subject: a mesh that is far away is brought near."""


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


@dataclass(frozen=True)
class Crystal:
    """What to do with atoms before they are looked at."""

    repeat: tuple[int, int, int] | None = None
    """How many times the cell is repeated along each of its vectors."""
    cut: float | None = None
    """Radius of the ball that is cut out, in Angstrom."""
    radius: float | None = None
    """Radius of all atoms, in Angstrom; None: it depends on the element."""

    @property
    def asked(self) -> bool:
        """Whether any of the three was asked for."""
        return any(value is not None for value in (self.repeat, self.cut, self.radius))


def open_source(path: Path, counted: Counted | None = None, crystal: Crystal | None = None) -> Opened:
    """Return the subject that a file holds. Raises SceneError or SettingsError.

    Of a molecule the surfaces are the atoms, so that ``counted`` can have weights alone, by element.
    """
    counted, crystal = counted or Counted(), crystal or Crystal()
    if path.suffix.lower() in atom_files.SUFFIXES:
        if counted.surfaces is not None or counted.groups or counted.by_light:
            raise SettingsError(
                f"The surfaces of a molecule are its atoms, without light: leave out 'surfaces', 'group' and "
                f"'by-light' for '{path}'."
            )
        opened = open_atoms(path, crystal)
    elif crystal.asked:
        raise SettingsError(f"Repeating, cutting and the radius of atoms are for molecules, and '{path}' is none.")
    else:
        opened = open_scene_file(path, counted)
    subject = opened.subject
    if counted.by_light:
        subject = with_weights(subject, shown_by_light(subject))
    return replace(opened, subject=weighted(subject, counted.weights) if counted.weights else subject)


def open_scene_file(path: Path, counted: Counted) -> Opened:
    """Return the subject that a scene or a mesh file holds. Raises SceneError or SettingsError."""
    suffix = path.suffix.lower()
    kind = counted.surfaces or ("shape" if counted.groups else "face")
    if suffix in mesh_files.SUFFIXES:
        parts, (x, y, z) = mesh_files.recentred(mesh_files.read_parts(path))
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


def open_atoms(path: Path, crystal: Crystal) -> Opened:
    """Return a molecule or crystal as a subject.

    A crystal that is neither to be repeated nor to be cut is cut to a ball, as a single cell shows little.
    """
    original = atoms = read_molecule(path)
    if crystal.repeat is not None:
        atoms = molecules.repeat(atoms, crystal.repeat)
    if crystal.cut is not None:
        atoms = molecules.ball(atoms, crystal.cut)
    elif crystal.repeat is None and atoms.cell is not None:
        atoms = molecules.ball(atoms, float(np.linalg.norm(atoms.cell, axis=1).max()) * 1.5)
    return Opened(
        molecules.open_molecule(atoms, crystal.radius),
        colours=molecules.colours_of(atoms.symbols),
        orthographic=True,
        axes=molecules.zone_axes(original),
        crystal=original.cell is not None,
    )


def read_molecule(path: Path) -> atom_files.Atoms:
    """Return the atoms of a file. Raises SceneError, or MissingPackageError without ASE."""
    require_package("ase", "ase", f"'{path}' is a molecule, and reading it", "view")
    return atom_files.read_atoms(path)


def open_pair_of_files(path: Path, other: Path, counted: Counted, crystal: Crystal) -> tuple[Opened, Pair]:
    """Return a molecule as it is seen from another one, and both; see ``tracer.viewpoint.docking``.

    The other one hides what lies behind it and does not count. Raises SceneError or SettingsError.
    """
    for molecule in (path, other):
        if molecule.suffix.lower() not in atom_files.SUFFIXES:
            raise SettingsError(f"From a surface, molecules are looked at, and '{molecule}' is none by its name.")
    if crystal.repeat is not None or crystal.cut is not None or counted.surfaces or counted.groups or counted.by_light:
        raise SettingsError(
            "With --from, atoms are taken as they are: leave out repeat, cut, surfaces, group, by-light."
        )
    pair = Pair(read_molecule(path), read_molecule(other))
    subject = open_pair(pair.seen, pair.seen_from, crystal.radius)
    if counted.weights:
        subject = weighted(subject, counted.weights)
    colours = molecules.colours_of([*pair.seen.symbols, *pair.seen_from.symbols])
    return Opened(subject, colours=colours), pair
