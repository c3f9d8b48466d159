"""Atoms of PDB and mmCIF files, the formats of proteins, which gemmi reads: one model, or one biological assembly.

ASE is not used: it takes an alpha carbon in old PDB files for calcium, and does not know mmCIF.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.errors import SettingsError

OLD = re.compile(r"^(?:ATOM  |HETATM).{70} *\d+ *$", re.MULTILINE)
"""An atom in an old PDB file, whose last eight columns held the name of the file and the number of the line."""
OLD_LENGTH = 72
"""Lines of such a file mean something up to this column; the element is then where the name of the atom begins."""
NEEDED = ("id", "type_symbol", "label_asym_id", "label_alt_id", "Cartn_x", "Cartn_y", "Cartn_z")
"""The table of atoms of an mmCIF file must have these columns, or gemmi finds no atoms."""
MOST_LISTED = 12
"""A message lists at most this many names."""


@dataclass(frozen=True)
class Part:
    """Which of the structures in a file is wanted."""

    model: str | None = None
    """Number of a model; None: the first."""
    assembly: str | None = None
    """Name of a biological assembly; None: the atoms as they are in the file."""


def read_structure(path: Path, part: Part) -> tuple[list[str], Floats, str]:
    """Return (symbols, positions (N, 3), remark) of the atoms of a PDB or mmCIF file, each at one of its places.

    ``remark``: a sentence about what else the file has, or nothing. Raises SettingsError for a model or an assembly
    that it does not have, and ValueError or RuntimeError if it cannot be read.
    """
    import gemmi

    structure = from_mmcif(path) if path.suffix.lower() in (".cif", ".mmcif") else from_pdb(path)
    if not len(structure):
        return [], np.zeros((0, 3)), ""
    numbers = [str(model.num) for model in structure]
    model = structure[position_of(path, "model", part.model, numbers) if part.model is not None else 0]
    remark = ""
    if part.model is None and len(numbers) > 1:
        remark = f"'{path}' has {len(numbers)} models, and this is the first; --model takes another."
    if part.assembly is not None:
        names = [assembly.name for assembly in structure.assemblies]
        assembly = structure.assemblies[position_of(path, "assembly", part.assembly, names)]
        # Copies of a chain have names of their own, so that alternate places in them are told apart.
        model = gemmi.make_assembly(assembly, model, gemmi.HowToNameCopiedChain.AddNumber)
    alone = gemmi.Structure()
    alone.add_model(model)
    flat = gemmi.FlatStructure(alone)
    kept = at_one_place(flat)
    symbols = np.char.capitalize(flat.element_names[kept].astype(str))
    return symbols.tolist(), np.array(flat.pos, np.float64).reshape(-1, 3)[kept], remark


def position_of(path: Path, kind: str, name: str, names: list[str]) -> int:
    """Return the position of a name. Raises SettingsError with the names that exist if it is not one of them."""
    if name in names:
        return names.index(name)
    if not names:
        raise SettingsError(f"'{path}' has no {kind} {name}: it has none.")
    existing = ", ".join(names if len(names) <= MOST_LISTED else [*names[: MOST_LISTED - 1], "...", names[-1]])
    raise SettingsError(f"'{path}' has no {kind} {name}; it has {existing}.")


def from_pdb(path: Path) -> Any:
    """Return the gemmi structure in a PDB file."""
    import gemmi

    text = path.read_text(encoding="utf-8", errors="replace")
    return gemmi.read_pdb(str(path), max_line_length=OLD_LENGTH if OLD.search(text) else 0)


def is_mmcif(path: Path) -> bool:
    """Return whether the names of columns in a CIF file have categories, as in mmCIF."""
    text = path.read_text(encoding="utf-8", errors="replace")
    return re.search(r"^\s*_atom_site\.", text, re.MULTILINE | re.IGNORECASE) is not None


def from_mmcif(path: Path) -> Any:
    """Return the gemmi structure in the first block of an mmCIF file. Raises ValueError if a column is missing."""
    import gemmi

    block = gemmi.cif.read(str(path))[0]
    missing = [name for name in NEEDED if not block.find([f"_atom_site.{name}"])]
    if missing:
        raise ValueError(f"its table of atoms has no {', '.join('_atom_site.' + name for name in missing)}")
    return gemmi.make_structure_from_block(block)


def at_one_place(flat: Any) -> Integers:
    """Return the numbers (K,) of atoms in the order of the file, each at the first of its places with most occupancy.

    An atom is known by its chain, residue and name; the kind of the residue may alternate as well. Atoms that share
    these and the letter of their place are different atoms with the same name.
    """
    letters = np.asarray(flat.altlocs)
    if not letters.any():
        return np.arange(len(letters))
    columns = (flat.chain_ids, flat.resnums[:, None], flat.icodes[:, None], flat.atom_names)
    site = groups_of(np.concatenate([np.asarray(column, np.int64) for column in columns], axis=1))
    namesake = rank_within(groups_of(np.column_stack([site, letters])))
    atom = groups_of(np.column_stack([site, namesake]))
    order = np.lexsort((np.arange(len(atom)), -np.asarray(flat.occ), atom))
    first = np.append(True, atom[order][1:] != atom[order][:-1])
    return np.sort(order[first])


def groups_of(rows: NDArray[np.int64]) -> Integers:
    """Return numbers (N,) that are the same for rows (N, D) that are the same."""
    return np.asarray(np.unique(rows, axis=0, return_inverse=True)[1], np.int64).reshape(-1)


def rank_within(group: Integers) -> Integers:
    """Return how many of the same group (N,) come before each."""
    order = np.argsort(group, kind="stable")
    first = np.searchsorted(group[order], group[order])
    rank = np.empty(len(group), np.int64)
    rank[order] = np.arange(len(group)) - first
    return rank
