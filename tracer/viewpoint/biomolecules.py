"""Atoms of PDB and mmCIF files, of which proteins come: the first model, alternate places of an atom only once.

ASE reads neither for us: in old PDB files it takes an alpha carbon for calcium, and mmCIF it does not know.
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
KEYWORD = re.compile(r"_|(loop|data|save|global|stop)_", re.IGNORECASE)
NEEDED = ("type_symbol", "cartn_x", "cartn_y", "cartn_z")


@dataclass(frozen=True)
class Placed:
    """An atom at one of its places."""

    symbol: str
    place: tuple[float, float, float]
    site: Hashable
    """Which atom it is: chain, residue, name. Of the same residue, as its kind may alternate as well."""
    alternate: str = ""
    """Letter of the place; empty where there is one only."""
    occupancy: float = 1.0


def once(atoms: list[Placed]) -> list[Placed]:
    """Return each atom at its place of the largest occupancy, of several the first, in the order of the file.

    Atoms that have the site and the letter in common are different ones, whose names are not told apart.
    """
    before: Counter[Hashable] = Counter()
    best: dict[Hashable, Placed] = {}
    for atom in atoms:
        key = (atom.site, before[atom.site, atom.alternate])
        before[atom.site, atom.alternate] += 1
        if key not in best or atom.occupancy > best[key].occupancy:
            best[key] = atom  # stays where the first place was
    return list(best.values())


def from_pdb(text: str) -> list[Placed]:
    """Return the atoms of the first model of a PDB file.

    The element is in columns 77 and 78, in old files, which have a line number there, in the name (columns 13 and 14).
    """
    found = []
    for line in text.splitlines():
        if line.startswith("ENDMDL"):
            break
        if line.startswith(("ATOM  ", "HETATM")):
            column = line[76:78].strip()
            name = line[12:16]
            # A hydrogen's name of four letters begins where the element of two would, as in HG11.
            own = "H" if len(name.strip()) == 4 and name[0] == "H" else name[:2].strip(" 0123456789")
            x, y, z = (float(line[begin : begin + 8]) for begin in (30, 38, 46))
            symbol = (column if column.isalpha() else own).capitalize()
            site = (line[21:22], line[22:27], name)
            found.append(Placed(symbol, (x, y, z), site, line[16:17].strip(), float(line[54:60].strip() or 1)))
    return once(found)


def is_mmcif(text: str) -> bool:
    """Return whether the names of a CIF file have categories, as those of mmCIF do."""
    return re.search(r"^\s*_atom_site\.", text, re.MULTILINE | re.IGNORECASE) is not None


def from_mmcif(text: str) -> list[Placed]:
    """Return the atoms of the first model of an mmCIF file. Raises ValueError where something is missing."""
    table = category(text, "_atom_site.")
    missing = [name for name in NEEDED if name not in table]
    if missing:
        raise ValueError(f"its table of atoms has no {', '.join('_atom_site.' + name for name in missing)}")
    rows = [dict(zip(table, row, strict=True)) for row in zip(*table.values(), strict=True)]
    found = []
    for row in rows:
        if row.get("pdbx_pdb_model_num") != rows[0].get("pdbx_pdb_model_num"):
            continue
        known = {name: value for name, value in row.items() if value not in (".", "?")}
        x, y, z = (float(row[name].partition("(")[0]) for name in NEEDED[1:])  # 1.234(5): with its uncertainty
        chain, residue, name = (
            known.get(f"auth_{what}", known.get(f"label_{what}", "")) for what in ("asym_id", "seq_id", "atom_id")
        )
        site = (chain, residue, known.get("pdbx_pdb_ins_code", ""), name)
        occupancy = float(known.get("occupancy", "1").partition("(")[0])
        found.append(Placed(row["type_symbol"].capitalize(), (x, y, z), site, known.get("label_alt_id", ""), occupancy))
    return once(found)


def category(text: str, name: str) -> dict[str, list[str]]:
    """Return the first table of a CIF file whose columns are called ``name`` and more: columns by that, in lower case.

    A table of one row may be written as pairs of name and value.
    """
    tokens = list(tokenised(text))
    ends = [k for k, (value, bare) in enumerate(tokens) if bare and KEYWORD.match(value)] + [len(tokens)]
    names: list[str] = []  # of the columns whose values come next
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
            columns |= {each.removeprefix(name): values[row :: len(names)] for row, each in enumerate(names)}
        names = [] if values else names
    return columns


def tokenised(text: str) -> Iterator[tuple[str, bool]]:
    """Yield the words of a CIF file, and whether each is bare, not quoted."""
    for match in TOKEN.finditer(text):
        if match.lastgroup is not None:
            yield match[match.lastgroup], match.lastgroup == "bare"
