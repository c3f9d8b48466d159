"""Atoms from files.

Most are read by ASE, but CML, PDB and mmCIF, and of XYZ it is given what it can read. Lengths are in Angstrom.
"""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tracer.core.arrays import Floats
from tracer.errors import SceneError
from tracer.viewpoint.biomolecules import Placed, from_mmcif, from_pdb, is_mmcif

SUFFIXES = (".xyz", ".extxyz", ".cif", ".mmcif", ".pdb", ".ent", ".cml", ".vasp", ".poscar", ".mol", ".sdf")


@dataclass(frozen=True)
class Atoms:
    """Atoms in space, and the cell in which they repeat."""

    symbols: list[str]
    positions: Floats
    """(N, 3)."""
    cell: Floats | None = None
    """(3, 3): rows are the vectors of the cell; None for a molecule."""

    def __len__(self) -> int:
        return len(self.symbols)


def read_atoms(path: str | Path) -> Atoms:
    """Return the atoms of a file. Raises SceneError if it is missing, does not parse, or has none."""
    path = Path(path)
    if not path.is_file():
        raise SceneError(f"There is no molecule file '{path}'.")
    try:
        found = READERS.get(path.suffix.lower(), read_by_ase)(path)
    except Exception as error:  # whatever a library raises for a file that is not what its name says
        first = (str(error).splitlines() or [type(error).__name__])[0]
        if isinstance(error, KeyError):
            first = f"there is no element {error}"
        elif isinstance(error, StopIteration):
            first = "it ends before its atoms do"
        elif not str(error) or not first.isprintable():
            first = f"{type(error).__name__} while reading it"
        raise SceneError(f"'{path}' is not a molecule that can be read: {first.rstrip('.')}.") from None
    if not len(found):
        raise SceneError(f"'{path}' has no atoms.")
    if not np.all(np.isfinite(found.positions)):
        raise SceneError(f"'{path}' has an atom without a place; check its coordinates.")
    return found


def read_by_ase(source: Any, **options: Any) -> Atoms:
    """Return the atoms of a file that ASE knows, the last of several structures."""
    import ase.io

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        atoms = ase.io.read(source, **options)
    if isinstance(atoms, list):
        atoms = atoms[-1]
    repeats = bool(np.all(atoms.pbc)) and abs(np.linalg.det(atoms.cell.array)) > 0
    cell = np.array(atoms.cell.array, np.float64) if repeats else None
    return Atoms(list(atoms.get_chemical_symbols()), np.array(atoms.positions, np.float64), cell)


def read_xyz(path: Path) -> Atoms:
    """Return the atoms of the last frame of an XYZ file, plain or extended.

    Lines between frames may be empty, and elements atomic numbers, neither of which ASE reads.
    """
    return read_by_ase(io.StringIO("\n".join(named(last_frame(contents(path)))) + "\n"), format="extxyz")


def last_frame(text: str) -> list[str]:
    """Return the lines of the last frame of an XYZ file. Raises ValueError."""
    lines = text.splitlines()
    frame: list[str] = []
    begin = 0
    while begin < len(lines):
        count = lines[begin].strip()
        if not count:
            begin += 1
            continue
        if not count.isdecimal():
            raise ValueError(f"line {begin + 1} should be a number of atoms and is '{count[:40]}'")
        end = begin + 2 + int(count)
        if end > len(lines):
            raise ValueError(f"it says that it has {int(count)} atoms, and has {len(lines) - begin - 1} lines")
        while end < len(lines) and lines[end].lstrip().startswith("VEC"):  # vectors of the cell
            end += 1
        frame, begin = lines[begin:end], end
    return frame


def named(frame: list[str]) -> list[str]:
    """Return a frame with symbols instead of atomic numbers, where elements come first."""
    from ase.data import chemical_symbols

    if len(frame) < 3 or ("Properties=" in frame[1] and "Properties=species" not in frame[1]):
        return frame
    found = []
    for line in frame[2:]:
        first, *others = line.split() or [""]
        if first.isdecimal() and int(first) >= len(chemical_symbols):
            raise ValueError(f"there is no element {first}")
        found.append(" ".join([chemical_symbols[int(first)], *others]) if first.isdecimal() else line)
    return [*frame[:2], *found]


def read_cif(path: Path) -> Atoms:
    """Return the atoms of a CIF file: of a crystal with its cell, or of a macromolecule (mmCIF) without."""
    text = contents(path)
    return gathered(from_mmcif(text)) if is_mmcif(text) else read_by_ase(path, format="cif")


def read_pdb(path: Path) -> Atoms:
    """Return the atoms of the first model of a PDB file; alternate places of an atom only once."""
    return gathered(from_pdb(contents(path)))


def contents(path: Path) -> str:
    """Return the text of a file."""
    return path.read_text(encoding="utf-8", errors="replace")


def gathered(atoms: list[Placed]) -> Atoms:
    """Return atoms without a cell."""
    return Atoms([atom.symbol for atom in atoms], np.array([atom.place for atom in atoms], np.float64).reshape(-1, 3))


def read_cml(path: Path) -> Atoms:
    """Return the atoms of a Chemical Markup Language file: all elements ``atom`` with x3, y3, z3."""
    symbols, positions = [], []
    for element in ElementTree.parse(path).iter():
        if element.tag.rpartition("}")[2] == "atom" and "x3" in element.attrib:
            symbols.append(element.attrib.get("elementType", "X"))
            positions.append([float(element.attrib[axis]) for axis in ("x3", "y3", "z3")])
    return Atoms(symbols, np.array(positions).reshape(-1, 3))


READERS = {
    ".cml": read_cml,
    ".pdb": read_pdb,
    ".ent": read_pdb,
    ".xyz": read_xyz,
    ".extxyz": read_xyz,
    ".cif": read_cif,
    ".mmcif": read_cif,
}
"""By suffix; what is not here ASE reads."""
