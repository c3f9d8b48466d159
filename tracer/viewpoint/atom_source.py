"""Open a file of atoms as a subject: a molecule, a crystal, or two molecules of which one is seen from the other."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.extras import require_package
from tracer.errors import SettingsError
from tracer.viewpoint import atom_files, molecules
from tracer.viewpoint.balls_and_sticks import faces_of_ball
from tracer.viewpoint.biomolecules import Part
from tracer.viewpoint.bonds import find_bonds
from tracer.viewpoint.docking import Pair, open_pair
from tracer.viewpoint.elements import colours_of
from tracer.viewpoint.opened import Opened

NO_BONDS = np.zeros((0, 2), np.int64)
"""Of a model that fills space, no bond is shown."""


@dataclass(frozen=True)
class Shown:
    """Which atoms of a file are looked at, and how they are shown."""

    repeat: tuple[int, int, int] | None = None
    """How many times the cell is repeated along each of its vectors."""
    cut: float | None = None
    """Radius of the ball that is cut out, in Angstrom."""
    radius: float | None = None
    """Radius of all atoms, in Angstrom; None: it depends on the element and the style."""
    style: molecules.Style | None = None
    """How atoms are shown; None: as balls and sticks."""
    count_bonds: bool = False
    """Whether bonds count as surfaces."""
    part: Part = field(default_factory=Part)
    """Which of the structures in the file."""


def open_atoms(path: Path, shown: Shown) -> Opened:
    """Return a molecule or crystal as a subject. Raises SceneError or SettingsError.

    A crystal that is neither to be repeated nor to be cut is cut to a ball, as a single cell shows little.
    """
    style = shown.style or "ball-and-stick"
    if shown.count_bonds and style == "space-filling":
        raise SettingsError("Balls that fill space have no bonds to count: leave out --count-bonds, or --style.")
    original = atoms = read_molecule(path, shown.part)
    if shown.repeat is not None:
        atoms = molecules.repeat(atoms, shown.repeat)
    if shown.cut is not None:
        atoms = molecules.ball(atoms, shown.cut)
    elif shown.repeat is None and atoms.cell is not None:
        atoms = molecules.ball(atoms, float(np.linalg.norm(atoms.cell, axis=1).max()) * 1.5)
    molecules.require_few(len(atoms))
    atoms, origin = molecules.recentred(atoms)
    bonds = find_bonds(atoms) if style == "ball-and-stick" else NO_BONDS
    return Opened(
        molecules.open_molecule(atoms, shown.radius, bonds, shown.count_bonds, style),
        colours=colours_of_faces(atoms.symbols, bonds),
        orthographic=True,
        axes=molecules.zone_axes(original),
        crystal=original.cell is not None,
        origin=(float(origin[0]), float(origin[1]), float(origin[2])),
        remarks=tuple(sentence for sentence in (original.remark, about_bonds(bonds, shown.count_bonds)) if sentence),
    )


def about_bonds(bonds: Integers, counted: bool) -> str:
    """Return the sentence that says whether bonds count; nothing if there is none."""
    if not len(bonds):
        return ""
    found = f"{len(bonds)} bonds are drawn" if len(bonds) > 1 else "One bond is drawn"
    if counted:
        return f"{found}, and count as surfaces, as atoms do."
    return f"{found}; they hide what is behind them and count as background, unless --count-bonds is given."


def colours_of_faces(symbols: list[str], bonds: Integers) -> Floats:
    """Return the colours (F, 3), linear sRGB, of the faces of atoms, and of the halves of ``bonds`` (B, 2)."""
    colours = colours_of(symbols).astype(np.float32)
    return np.concatenate([np.repeat(colours, faces_of_ball(len(symbols)), axis=0), colours[bonds.ravel()]])


def read_molecule(path: Path, part: Part | None = None) -> atom_files.Atoms:
    """Return the atoms of a file. Raises SceneError, SettingsError, or MissingPackageError without ASE or gemmi."""
    require_package("ase", "ase", f"'{path}' is a molecule, and reading it", "view")
    return atom_files.read_atoms(path, part)


def open_pair_of_atoms(path: Path, other: Path, shown: Shown) -> tuple[Opened, Pair]:
    """Return a molecule as it is seen from another one, and both; see ``tracer.viewpoint.docking``.

    The other one hides what lies behind it and does not count. Of both, the first model is taken. Raises SceneError or
    SettingsError.
    """
    for molecule in (path, other):
        if molecule.suffix.lower() not in atom_files.SUFFIXES:
            raise SettingsError(f"From a surface, molecules are looked at, and '{molecule}' is none by its name.")
    if shown != Shown(radius=shown.radius):
        raise SettingsError(
            "With --from, atoms are taken as they are and fill space: leave out repeat, cut, model, assembly, style, "
            "count-bonds."
        )
    seen, seen_from = read_molecule(path), read_molecule(other)
    both = atom_files.Atoms([*seen.symbols, *seen_from.symbols], np.concatenate([seen.positions, seen_from.positions]))
    both, origin = molecules.recentred(both)
    pair = Pair(
        replace(seen, positions=both.positions[: len(seen)]), replace(seen_from, positions=both.positions[len(seen) :])
    )
    subject = open_pair(pair.seen, pair.seen_from, shown.radius)
    return Opened(
        subject,
        colours=colours_of_faces(both.symbols, NO_BONDS),
        origin=(float(origin[0]), float(origin[1]), float(origin[2])),
        remarks=tuple(atoms.remark for atoms in (seen, seen_from) if atoms.remark),
    ), pair
