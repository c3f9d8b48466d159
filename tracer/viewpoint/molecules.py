"""Molecules and crystals: atoms as balls, each one surface (the paper, section 4.5).

Lengths are in Angstrom.
"""

from __future__ import annotations

import mitsuba as mi
import numpy as np
from numpy.typing import ArrayLike

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.core.sphere import icosphere, normalised
from tracer.errors import SettingsError
from tracer.image.colour import decode_srgb
from tracer.viewpoint.atom_files import Atoms
from tracer.viewpoint.surfaces import Subject, open_subject

BALL_LEVEL = 2
"""An atom is an icosphere of this level, which has 320 faces."""
MOST_ATOMS = 20_000
"""A subject has at most this many atoms."""
MOST_TRIED = 5_000_000
"""A ball is cut out of at most this many atoms."""
COVALENT_SHARE = 0.5
"""Balls have this share of the covalent radius unless a radius is given, as in a ball-and-stick model."""


def repeat(atoms: Atoms, times: tuple[int, int, int]) -> Atoms:
    """Return a crystal with its cell repeated along its three vectors.

    Raises SettingsError for a molecule, for a number of times below 1, and for too many atoms.
    """
    cell = cell_of(atoms)
    if min(times) < 1:
        raise SettingsError(f"A cell is repeated at least once along each axis, not {times}.")
    require_few(len(atoms) * int(np.prod(np.array(times, object))))
    shifts = np.stack(np.meshgrid(*(np.arange(count) for count in times), indexing="ij"), axis=-1).reshape(-1, 3) @ cell
    positions = (shifts[:, None] + atoms.positions).reshape(-1, 3)
    return Atoms(atoms.symbols * len(shifts), positions, cell * np.array(times)[:, None])


def ball(atoms: Atoms, radius: float, centre: ArrayLike | None = None) -> Atoms:
    """Return the atoms within ``radius`` of ``centre``, by default the mean place of all atoms.

    The cell of a crystal is repeated as often as the ball needs. A ball has no corners, which a box that is cut from a
    crystal would show. Raises SettingsError if the ball has no atom, or too many.
    """
    if not 0 < radius < np.inf:
        raise SettingsError(f"The radius of the ball to cut must be positive, not {radius:g}.")
    middle = atoms.positions.mean(axis=0) if centre is None else np.asarray(centre, np.float64)
    positions, symbols = atoms.positions, np.array(atoms.symbols)
    if atoms.cell is not None:
        heights = 1 / np.linalg.norm(np.linalg.inv(atoms.cell), axis=0)
        reach = np.linalg.norm(positions - middle, axis=1).max() + radius
        needed = np.ceil(reach / heights)
        if not np.all(needed < MOST_TRIED):
            raise SettingsError(f"A ball of {radius:g} Angstrom has too many atoms; cut out a smaller one.")
        repeats = needed.astype(int)
        require_few(len(atoms) * int(np.prod(2 * repeats.astype(object) + 1)), MOST_TRIED)
        shifts = np.stack(np.meshgrid(*(np.arange(-k, k + 1) for k in repeats), indexing="ij"), axis=-1).reshape(-1, 3)
        positions = ((shifts @ atoms.cell)[:, None] + positions).reshape(-1, 3)
        symbols = np.tile(symbols, len(shifts))
    inside = np.linalg.norm(positions - middle, axis=1) <= radius + 1e-9
    if not inside.any():
        raise SettingsError(f"No atom lies within {radius:g} Angstrom of {np.round(middle, 3).tolist()}.")
    return Atoms(symbols[inside].tolist(), positions[inside])


def cell_of(atoms: Atoms) -> Floats:
    """Return the cell (3, 3). Raises SettingsError if there is none."""
    if atoms.cell is None:
        raise SettingsError("A molecule has no cell that could be repeated; this is for crystals.")
    return atoms.cell


def zone_axes(atoms: Atoms, most: int = 2) -> Floats:
    """Return unit directions (N, 3) along which rows of atoms may line up.

    Views along them are narrow wells of a measure, which a grid of directions misses. The directions are the principal
    axes of the atoms, and for a crystal also the lattice directions, and the normals of lattice planes, with indices
    up to ``most``.
    """
    centred = atoms.positions - atoms.positions.mean(axis=0)
    axes = [np.linalg.eigh(centred.T @ centred)[1].T] if len(atoms) > 1 else []
    if atoms.cell is not None:
        steps = np.arange(-most, most + 1)
        indices = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
        first = np.array([next((k for k in row if k), 0) for row in indices])
        indices = indices[(first > 0) & (np.gcd.reduce(indices, axis=1) == 1)]
        axes.append(indices @ atoms.cell)
        axes.append(indices @ np.linalg.inv(atoms.cell).T)  # normals of lattice planes
    directions = np.concatenate(axes) if axes else np.eye(3)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def open_molecule(atoms: Atoms, radius: float | Floats | None = None) -> Subject:
    """Return atoms as a subject in which each atom is a surface, which has the name of its element.

    ``radius``: of all balls, or of each (N,), in Angstrom; None: half the covalent radius of each atom. Raises
    SettingsError.
    """
    require_few(len(atoms))
    if radius is not None and not (np.all(np.asarray(radius) > 0) and np.all(np.isfinite(radius))):
        raise SettingsError(f"The radius of atoms must be positive, not {radius}.")
    radii = COVALENT_SHARE * covalent_radii(atoms.symbols) if radius is None else np.full(len(atoms), radius)
    points, faces = icosphere(BALL_LEVEL)
    # Scaled to the mean projected area of the ball that it stands for: a quarter of the area of any convex body.
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
    return open_subject(scene, groups=np.repeat(np.arange(len(atoms)), len(faces)), names=atoms.symbols)


def require_few(count: int, most: int = MOST_ATOMS) -> None:
    """Raise SettingsError if ``count`` atoms are more than ``most``."""
    if count > most:
        raise SettingsError(f"{count} atoms are more than {most}; cut out a smaller ball, or repeat the cell less.")


def covalent_radii(symbols: list[str]) -> Floats:
    """Return covalent radii (N,) by element (B. Cordero and others, Dalton Transactions, 2008); 0.7 if unknown."""
    from ase.data import covalent_radii as table

    return radii_by_element(symbols, table, 0.7)


def van_der_waals_radii(symbols: list[str]) -> Floats:
    """Return van der Waals radii (N,) by element (S. Alvarez, Dalton Transactions, 2013); 2 if unknown."""
    from ase.data.vdw_alvarez import vdw_radii

    return radii_by_element(symbols, vdw_radii, 2.0)


def radii_by_element(symbols: list[str], table: Floats, unknown: float) -> Floats:
    """Return radii (N,) from a table by atomic number, in which number 0 is no element; ``unknown``: if it has none."""
    from ase.data import atomic_numbers

    numbers = np.array([atomic_numbers.get(symbol, 0) for symbol in symbols])
    radii = np.array([table[number] if number < len(table) else np.nan for number in numbers], np.float64)
    return np.where((numbers > 0) & np.isfinite(radii), radii, unknown)


def colours_of(symbols: list[str]) -> Floats:
    """Return colours (N, 3) of atoms by element, linear sRGB: those of Jmol, which chemists know."""
    from ase.data import atomic_numbers
    from ase.data.colors import jmol_colors

    encoded = np.array([jmol_colors[atomic_numbers.get(symbol, 0)] for symbol in symbols], np.float64)
    return decode_srgb(encoded)
