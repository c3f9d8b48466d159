"""Open a file that a person names as a subject: a Mitsuba scene, a mesh, a molecule or a crystal."""

from __future__ import annotations

from dataclasses import dataclass
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
from tracer.viewpoint.surfaces import Subject, open_subject

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


def open_source(path: Path, surfaces: str | None = None, crystal: Crystal | None = None) -> Opened:
    """Return the subject that a file holds. Raises SceneError or SettingsError.

    ``surfaces``: face (the default), shape or bsdf; must be None for a molecule, whose surfaces are its atoms.
    """
    crystal = crystal or Crystal()
    suffix = path.suffix.lower()
    if suffix in atom_files.SUFFIXES:
        if surfaces is not None:
            raise SettingsError(f"The surfaces of a molecule are its atoms: leave out 'surfaces' for '{path}'.")
        return open_atoms(path, crystal)
    if crystal.asked:
        raise SettingsError(f"Repeating, cutting and the radius of atoms are for molecules, and '{path}' is none.")
    if suffix in mesh_files.SUFFIXES:
        parts, (x, y, z) = mesh_files.recentred(mesh_files.read_parts(path))
        scene = mi.load_dict({"type": "scene", **shapes_of(parts)})
        origin = (float(x), float(y), float(z))
        return Opened(open_subject(scene, surfaces or "face"), up=up_of_file(path), origin=origin)
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
    return Opened(open_subject(scene, surfaces or "face"), up=upwards(scene))


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
    require_package("ase", "ase", f"'{path}' is a molecule, and reading it", "view")
    from ase.data import atomic_numbers
    from ase.data.colors import jmol_colors

    original = atoms = atom_files.read_atoms(path)
    if crystal.repeat is not None:
        atoms = molecules.repeat(atoms, crystal.repeat)
    if crystal.cut is not None:
        atoms = molecules.ball(atoms, crystal.cut)
    elif crystal.repeat is None and atoms.cell is not None:
        atoms = molecules.ball(atoms, float(np.linalg.norm(atoms.cell, axis=1).max()) * 1.5)
    encoded = np.array([jmol_colors[atomic_numbers.get(symbol, 0)] for symbol in atoms.symbols])
    return Opened(
        molecules.open_molecule(atoms, crystal.radius),
        colours=encoded**2.2,
        orthographic=True,
        axes=molecules.zone_axes(original),
        crystal=original.cell is not None,
    )
