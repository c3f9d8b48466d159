"""Atoms from files.

ASE reads most formats, gemmi PDB and mmCIF. CML is read here, and XYZ is first changed to what ASE can read.
Lengths are in Angstrom.
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
from tracer.core.extras import require_package
from tracer.errors import SceneError, SettingsError, TracerError
from tracer.viewpoint.biomolecules import Part, is_mmcif, read_structure

SUFFIXES = (".xyz", ".extxyz", ".cif", ".mmcif", ".pdb", ".ent", ".cml", ".vasp", ".poscar", ".mol", ".sdf")
"""Files with these suffixes are taken for molecules or crystals."""
OF_PROTEINS = (".pdb", ".ent", ".mmcif")
"""Files with these suffixes may have several models and assemblies, and so may those that end with .cif."""


@dataclass(frozen=True)
class Atoms:
    """Atoms in space, and the cell in which they repeat."""

    symbols: list[str]
    positions: Floats
    """(N, 3), in Angstrom."""
    cell: Floats | None = None
    """(3, 3), in Angstrom: rows are the vectors of the cell; None for a molecule."""
    remark: str = ""
    """A sentence about what else the file has, or nothing."""

    def __len__(self) -> int:
        return len(self.symbols)


def read_atoms(path: str | Path, part: Part | None = None) -> Atoms:
    """Return the atoms of a file; ``part``: which of several structures.

    Raises SceneError if it is missing, cannot be read, or has no atoms, SettingsError if it does not have the part, and
    MissingPackageError without gemmi if it is to be read by it.
    """
    path, part = Path(path), part or Part()
    if not path.is_file():
        raise SceneError(f"There is no molecule file '{path}'.")
    suffix = path.suffix.lower()
    try:
        if suffix in OF_PROTEINS or (suffix == ".cif" and is_mmcif(path)):
            require_package("gemmi", "gemmi", f"'{path}' is a structure, and reading it", "view")
            symbols, positions, remark = read_structure(path, part)
            atoms = Atoms(symbols, positions, remark=remark)
        elif part != Part():
            raise SettingsError(f"PDB and mmCIF files have models and assemblies, and '{path}' is none of these.")
        else:
            atoms = READERS.get(suffix, read_by_ase)(path)
    except TracerError:
        raise
    except Exception as error:  # whatever a library raises for a file that is not what its name says
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        if isinstance(error, KeyError):
            reason = f"there is no element {error}"
        elif isinstance(error, StopIteration):
            reason = "it ends before its atoms do"
        elif not str(error) or not reason.isprintable():
            reason = f"{type(error).__name__} while reading it"
        raise SceneError(f"'{path}' is not a molecule that can be read: {reason.rstrip('.:')}.") from None
    if not len(atoms):
        raise SceneError(f"'{path}' has no atoms.")
    if not np.all(np.isfinite(atoms.positions)):
        raise SceneError(f"'{path}' has an atom without a place; check its coordinates.")
    return atoms


def read_by_ase(source: Any, **options: Any) -> Atoms:
    """Return the atoms of a file that ASE can read; of several structures, the last one."""
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

    Lines between frames may be empty, and elements may be atomic numbers; ASE reads neither.
    """
    return read_by_ase(io.StringIO("\n".join(named(last_frame(contents(path)))) + "\n"), format="extxyz")


def last_frame(text: str) -> list[str]:
    """Return the lines of the last frame of an XYZ file. Raises ValueError if a frame is not whole."""
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
    """Return a frame with symbols instead of atomic numbers, if its first column is the element."""
    from ase.data import chemical_symbols

    if len(frame) < 3 or ("Properties=" in frame[1] and "Properties=species" not in frame[1]):
        return frame
    atom_lines = []
    for line in frame[2:]:
        first, *columns = line.split() or [""]
        if first.isdecimal() and int(first) >= len(chemical_symbols):
            raise ValueError(f"there is no element {first}")
        atom_lines.append(" ".join([chemical_symbols[int(first)], *columns]) if first.isdecimal() else line)
    return [*frame[:2], *atom_lines]


def contents(path: Path) -> str:
    """Return the text of a file."""
    return path.read_text(encoding="utf-8", errors="replace")


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
    ".xyz": read_xyz,
    ".extxyz": read_xyz,
}
"""Files with these suffixes are read by these functions; ASE reads all others."""
