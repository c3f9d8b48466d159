"""Molecules and crystals: atoms as balls, each one surface (the paper, section 4.5).

Files are read by ASE, but for CML, which it does not know, and PDB, in whose old files it takes an alpha carbon for
calcium. Lengths are in Angstrom.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import mitsuba as mi
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tracer.errors import SceneError, SettingsError
from tracer.upload import upload
from tracer.viewpoint.sphere import icosphere, normalised
from tracer.viewpoint.subject import Subject, open_subject

Floats = NDArray[np.float64]
SUFFIXES = (".xyz", ".extxyz", ".cif", ".pdb", ".ent", ".cml", ".vasp", ".poscar", ".mol", ".sdf")
BALL_LEVEL = 2
"""Of the icosphere that stands for an atom: 320 faces."""
MOST_ATOMS = 20_000
MOST_TRIED = 5_000_000
"""Of which a ball is cut."""
COVALENT_SHARE = 0.5
"""Balls have this part of the covalent radius unless told otherwise: as in a ball-and-stick model."""


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
        found = {".cml": read_cml, ".pdb": read_pdb, ".ent": read_pdb}.get(path.suffix.lower(), read_by_ase)(path)
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


COUNTED = (".xyz", ".extxyz")
"""Formats that begin with the number of atoms."""


def read_by_ase(path: Path) -> Atoms:
    """Return the atoms of a file that ASE knows, the last of several structures."""
    import ase.io

    if path.suffix.lower() in COUNTED:
        with open(path, "rb") as file:
            claimed, lines = file.readline().strip(), sum(1 for _ in file)
        if claimed.isdigit() and int(claimed) > lines:  # ASE would wait for them for ever
            raise ValueError(f"it says that it has {int(claimed)} atoms, and has {lines} lines")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of parts that are not used here; atoms and places are checked below
        atoms = ase.io.read(path)
    if isinstance(atoms, list):
        atoms = atoms[-1]
    repeats = bool(np.all(atoms.pbc)) and abs(np.linalg.det(atoms.cell.array)) > 0
    cell = np.array(atoms.cell.array, np.float64) if repeats else None
    return Atoms(list(atoms.get_chemical_symbols()), np.array(atoms.positions, np.float64), cell)


def read_cml(path: Path) -> Atoms:
    """Return the atoms of a Chemical Markup Language file: all elements ``atom`` with x3, y3, z3."""
    symbols, positions = [], []
    for element in ElementTree.parse(path).iter():
        if element.tag.rpartition("}")[2] == "atom" and "x3" in element.attrib:
            symbols.append(element.attrib.get("elementType", "X"))
            positions.append([float(element.attrib[axis]) for axis in ("x3", "y3", "z3")])
    return Atoms(symbols, np.array(positions).reshape(-1, 3))


def read_pdb(path: Path) -> Atoms:
    """Return the atoms of the first model of a PDB file; alternate places of an atom only once.

    The element is in columns 77 and 78, in old files, which have a line number there, in the name (columns 13 and 14).
    """
    symbols, positions = [], []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        if line.startswith("ENDMDL"):
            break
        if line.startswith(("ATOM  ", "HETATM")) and line[16:17] in " A1":
            column = line[76:78].strip()
            name = line[12:16]
            # A hydrogen's name of four letters begins where the element of two would, as in HG11.
            own = "H" if len(name.strip()) == 4 and name[0] == "H" else name[:2].strip(" 0123456789")
            symbols.append((column if column.isalpha() else own).capitalize())
            positions.append([float(line[begin : begin + 8]) for begin in (30, 38, 46)])
    return Atoms(symbols, np.array(positions).reshape(-1, 3))


def repeat(atoms: Atoms, times: tuple[int, int, int]) -> Atoms:
    """Return a crystal with its cell repeated along its three vectors. Raises SettingsError for a molecule."""
    cell = cell_of(atoms)
    if min(times) < 1:
        raise SettingsError(f"A cell is repeated at least once along each axis, not {times}.")
    require_few(len(atoms) * int(np.prod(np.array(times, object))))
    shifts = np.stack(np.meshgrid(*(np.arange(n) for n in times), indexing="ij"), axis=-1).reshape(-1, 3) @ cell
    positions = (shifts[:, None] + atoms.positions).reshape(-1, 3)
    return Atoms(atoms.symbols * len(shifts), positions, cell * np.array(times)[:, None])


def ball(atoms: Atoms, radius: float, centre: ArrayLike | None = None) -> Atoms:
    """Return the atoms within ``radius`` of ``centre`` (the middle of the cell's atoms), a crystal's cell repeated.

    A shape without corners of its own: a box cut from a crystal would show those. Raises SettingsError where the ball
    has no atom.
    """
    if not 0 < radius < np.inf:
        raise SettingsError(f"The radius of the ball to cut must be positive, not {radius:g}.")
    middle = atoms.positions.mean(axis=0) if centre is None else np.asarray(centre, np.float64)
    positions, symbols = atoms.positions, np.array(atoms.symbols)
    if atoms.cell is not None:
        heights = 1 / np.linalg.norm(np.linalg.inv(atoms.cell), axis=0)
        reach = np.linalg.norm(positions - middle, axis=1).max() + radius
        wanted = np.ceil(reach / heights)
        if not np.all(wanted < MOST_TRIED):
            raise SettingsError(f"A ball of {radius:g} Angstrom has too many atoms; cut out a smaller one.")
        n = wanted.astype(int)
        require_few(len(atoms) * int(np.prod(2 * n.astype(object) + 1)), MOST_TRIED)
        shifts = np.stack(np.meshgrid(*(np.arange(-k, k + 1) for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
        positions = ((shifts @ atoms.cell)[:, None] + positions).reshape(-1, 3)
        symbols = np.tile(symbols, len(shifts))
    inside = np.linalg.norm(positions - middle, axis=1) <= radius + 1e-9
    if not inside.any():
        raise SettingsError(f"No atom lies within {radius:g} Angstrom of {np.round(middle, 3).tolist()}.")
    return Atoms(symbols[inside].tolist(), positions[inside])


def cell_of(atoms: Atoms) -> Floats:
    """Return the cell. Raises SettingsError where there is none."""
    if atoms.cell is None:
        raise SettingsError("A molecule has no cell that could be repeated; this is for crystals.")
    return atoms.cell


def zone_axes(atoms: Atoms, most: int = 2) -> Floats:
    """Return the directions (N, 3) of the lattice with indices up to ``most``: where rows of atoms line up.

    Views along them are narrow wells that a grid of directions misses. Also with the axes of the atoms themselves,
    their principal ones, which is all that a molecule has.
    """
    centred = atoms.positions - atoms.positions.mean(axis=0)
    axes = [np.linalg.eigh(centred.T @ centred)[1].T] if len(atoms) > 1 else []
    if atoms.cell is not None:
        n = np.arange(-most, most + 1)
        indices = np.stack(np.meshgrid(n, n, n, indexing="ij"), axis=-1).reshape(-1, 3)
        first = np.array([next((k for k in row if k), 0) for row in indices])
        indices = indices[(first > 0) & (np.gcd.reduce(indices, axis=1) == 1)]
        axes.append(indices @ atoms.cell)
        axes.append(indices @ np.linalg.inv(atoms.cell).T)  # normals of lattice planes
    found = np.concatenate(axes) if axes else np.eye(3)
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def open_molecule(atoms: Atoms, radius: float | None = None) -> Subject:
    """Return atoms as a subject, a surface an atom; ``radius``: of all balls, else half the covalent one of each."""
    require_few(len(atoms))
    if radius is not None and not 0 < radius < np.inf:
        raise SettingsError(f"The radius of atoms must be positive, not {radius:g}.")
    radii = np.full(len(atoms), radius) if radius is not None else COVALENT_SHARE * covalent_radii(atoms.symbols)
    points, faces = icosphere(BALL_LEVEL)
    # As wide, on average, as the ball it stands for: a convex body's mean projected area is a quarter of its area.
    a, b, c = points[faces].transpose(1, 0, 2)
    points = points * np.sqrt(8 * np.pi / np.linalg.norm(np.cross(b - a, c - a), axis=-1).sum())
    vertices = atoms.positions[:, None] + radii[:, None, None] * points
    triangles = np.arange(len(atoms))[:, None, None] * len(points) + faces
    mesh = mi.Mesh("atoms", vertices.size // 3, triangles.size // 3, has_vertex_normals=True)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = upload(mi.Float, vertices)
    parameters["vertex_normals"] = upload(mi.Float, np.tile(normalised(points), (len(atoms), 1)))
    parameters["faces"] = upload(mi.UInt32, triangles)
    parameters.update()
    scene = mi.load_dict({"type": "scene", "atoms": mesh})
    return open_subject(scene, groups=np.repeat(np.arange(len(atoms)), len(faces)))


def require_few(count: int, most: int = MOST_ATOMS) -> None:
    """Raise SettingsError for more atoms than can be looked at."""
    if count > most:
        raise SettingsError(f"{count} atoms are more than {most}; cut out a smaller ball, or repeat the cell less.")


def covalent_radii(symbols: list[str]) -> Floats:
    """Return covalent radii (N,) by element (B. Cordero and others, Dalton Transactions, 2008); 0.7 of what is none."""
    from ase.data import atomic_numbers
    from ase.data import covalent_radii as table

    radii = np.array([table[atomic_numbers.get(name, 0)] for name in symbols], np.float64)
    known = np.array([atomic_numbers.get(name, 0) > 0 for name in symbols]) & np.isfinite(radii)
    return np.where(known, radii, 0.7)
