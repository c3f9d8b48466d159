"""Atoms of PDB and mmCIF files, the formats of proteins: the first model, each atom at one of its alternate places.

ASE is not used: it takes an alpha carbon in old PDB files for calcium, and does not know mmCIF.
"""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Hashable, Iterator
from dataclasses import dataclass

TOKEN = re.compile(
    r"""^;(?P<text>.*?)\n;(?=\s|\Z)  # lines between semicolons
    |'(?P<single>[^\n]*?)'(?=\s|\Z)|"(?P<double>[^\n]*?)"(?=\s|\Z)  # a quote ends where a space follows
    |\#[^\n]*|(?P<bare>\S+)""",
    re.MULTILINE | re.DOTALL | re.VERBOSE,
)
"""This pattern matches a word of a CIF file, as one of its groups, or a comment, as none of them."""
KEYWORD = re.compile(r"_|(loop|data|save|global|stop)_", re.IGNORECASE)
"""A bare word that begins like this is the name of a column or a reserved word of CIF, not a value."""
NEEDED = ("type_symbol", "cartn_x", "cartn_y", "cartn_z")
"""The table of atoms of an mmCIF file must have these columns."""


@dataclass(frozen=True)
class Placed:
    """An atom at one of its places."""

    symbol: str
    place: tuple[float, float, float]
    site: Hashable
    """Which atom it is: chain, residue, name. The kind of the residue is left out, as it may alternate as well."""
    alternate: str = ""
    """Letter of the place; empty if the atom has only one."""
    occupancy: float = 1.0


def once(atoms: list[Placed]) -> list[Placed]:
    """Return each atom once, at the first of its places with the largest occupancy, in the order of the file.

    Atoms with the same site and the same letter are different atoms that have the same name.
    """
    counts: Counter[Hashable] = Counter()
    best: dict[Hashable, Placed] = {}
    for atom in atoms:
        key = (atom.site, counts[atom.site, atom.alternate])
        counts[atom.site, atom.alternate] += 1
        if key not in best or atom.occupancy > best[key].occupancy:
            best[key] = atom  # its position in the dictionary stays that of the first place
    return list(best.values())


def from_pdb(text: str) -> list[Placed]:
    """Return the atoms of the first model of a PDB file.

    The element is in columns 77 and 78. Old files have a line number there, and the element in columns 13 and 14, where
    the name begins.
    """
    atoms = []
    for line in text.splitlines():
        if line.startswith("ENDMDL"):
            break
        if line.startswith(("ATOM  ", "HETATM")):
            column = line[76:78].strip()
            name = line[12:16]
            # A hydrogen's name of four characters, such as HG11, begins in the column of elements of two letters.
            element_in_name = "H" if len(name.strip()) == 4 and name[0] == "H" else name[:2].strip(" 0123456789")
            x, y, z = (float(line[begin : begin + 8]) for begin in (30, 38, 46))
            symbol = (column if column.isalpha() else element_in_name).capitalize()
            site = (line[21:22], line[22:27], name)
            atoms.append(Placed(symbol, (x, y, z), site, line[16:17].strip(), float(line[54:60].strip() or 1)))
    return once(atoms)


def is_mmcif(text: str) -> bool:
    """Return whether the names of columns in a CIF file have categories, as in mmCIF."""
    return re.search(r"^\s*_atom_site\.", text, re.MULTILINE | re.IGNORECASE) is not None


def from_mmcif(text: str) -> list[Placed]:
    """Return the atoms of the first model of an mmCIF file. Raises ValueError if a column is missing."""
    table = category(text, "_atom_site.")
    missing = [name for name in NEEDED if name not in table]
    if missing:
        raise ValueError(f"its table of atoms has no {', '.join('_atom_site.' + name for name in missing)}")
    rows = [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]
    atoms = []
    for row in rows:
        if row.get("pdbx_pdb_model_num") != rows[0].get("pdbx_pdb_model_num"):
            continue
        known = {name: value for name, value in row.items() if value not in (".", "?")}
        # A number may be followed by its uncertainty in brackets, as in 1.234(5).
        x, y, z = (float(row[name].partition("(")[0]) for name in NEEDED[1:])
        chain, residue, name = (
            known.get(f"auth_{field}", known.get(f"label_{field}", "")) for field in ("asym_id", "seq_id", "atom_id")
        )
        site = (chain, residue, known.get("pdbx_pdb_ins_code", ""), name)
        occupancy = float(known.get("occupancy", "1").partition("(")[0])
        atoms.append(Placed(row["type_symbol"].capitalize(), (x, y, z), site, known.get("label_alt_id", ""), occupancy))
    return once(atoms)


def category(text: str, name: str) -> dict[str, list[str]]:
    """Return the first table of a CIF file whose column names begin with ``name``: columns by the rest of their names.

    Names are in lower case. A table of one row may be written as pairs of a name and a value. Raises ValueError if the
    last row is not whole.
    """
    tokens = list(tokenised(text))
    ends = [k for k, (value, bare) in enumerate(tokens) if bare and KEYWORD.match(value)] + [len(tokens)]
    names: list[str] = []  # names of the columns whose values come next
    columns: dict[str, list[str]] = {}
    for begin, end in itertools.pairwise(ends):
        key, values = tokens[begin][0].lower(), [value for value, _ in tokens[begin + 1 : end]]
        if not key.startswith("_"):
            if columns and key != "save_":
                break
            names = []
            continue
        names.append(key)
        if values and key.startswith(name):
            if len(values) % len(names):
                raise ValueError("the last row of its table of atoms is not whole")
            columns |= {
                heading.removeprefix(name): values[column :: len(names)] for column, heading in enumerate(names)
            }
        names = [] if values else names
    return columns


def tokenised(text: str) -> Iterator[tuple[str, bool]]:
    """Yield each word of a CIF file, and whether it is bare, that is not quoted."""
    for match in TOKEN.finditer(text):
        if match.lastgroup is not None:
            yield match[match.lastgroup], match.lastgroup == "bare"
