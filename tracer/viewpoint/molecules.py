"""Molecules and crystals: atoms as balls, each one surface, and bonds as sticks (the paper, section 4.5).

Lengths are in Angstrom.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from tracer.core.arrays import Floats, Integers
from tracer.errors import SettingsError
from tracer.scene.parts import DIGITS
from tracer.viewpoint.atom_files import Atoms
from tracer.viewpoint.balls_and_sticks import faces_of_ball, scene_of
from tracer.viewpoint.elements import van_der_waals_radii
from tracer.viewpoint.surfaces import NO_MESH, NOT_COUNTED, Subject, open_subject

MOST_ATOMS = 200_000
"""A subject has at most this many atoms."""
MOST_TRIED = 5_000_000
"""A ball is cut out of at most this many atoms."""
BALL_SHARE = 0.25
"""Balls with sticks have this share of the van der Waals radius unless a radius is given."""
STICK = 0.14
"""Radius of a stick; it is at most half that of the smallest ball."""
BOND = "bond"
"""Bonds that count have this name."""
Style = Literal["ball-and-stick", "space-filling"]
"""How atoms are shown: as small balls with bonds between them, or as balls of the size that they have for others."""


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


def recentred(atoms: Atoms) -> tuple[Atoms, Floats]:
    """Return atoms near enough to the origin for single precision, and where their origin was (3,)."""
    low, high = atoms.positions.min(axis=0), atoms.positions.max(axis=0)
    middle: Floats = (low + high) / 2
    if np.abs(middle).max() * DIGITS <= max(float(np.linalg.norm(high - low)), 1.0):
        return atoms, np.zeros(3)
    return replace(atoms, positions=atoms.positions - middle), middle


def ball_radii(atoms: Atoms, style: Style, radius: float | Floats | None = None) -> Floats:
    """Return the radii (N,) of the balls; ``radius``: of all, or of each (N,), instead of what the style has.

    Raises SettingsError for a radius that is not positive.
    """
    if radius is not None and not (np.all(np.asarray(radius) > 0) and np.all(np.isfinite(radius))):
        raise SettingsError(f"The radius of atoms must be positive, not {radius}.")
    if radius is not None:
        return np.full(len(atoms), radius, np.float64)
    return van_der_waals_radii(atoms.symbols) * (BALL_SHARE if style == "ball-and-stick" else 1.0)


def open_molecule(
    atoms: Atoms,
    radius: float | Floats | None = None,
    bonds: Integers | None = None,
    count_bonds: bool = False,
    style: Style = "ball-and-stick",
) -> Subject:
    """Return atoms as a subject in which each atom is a surface, which has the name of its element.

    The faces are ``faces_of_ball`` of each atom, and then two halves of each of ``bonds`` (B, 2), by default none.
    ``radius`` and ``style``: see ``ball_radii``. ``count_bonds``: whether each bond is a surface, too. Else bonds hide
    what lies behind them and count as background: every share stays a share of the same image, whatever is measured
    and with however few rays. Raises SettingsError.
    """
    require_few(len(atoms))
    radii = ball_radii(atoms, style, radius)
    bonds = np.zeros((0, 2), np.int64) if bonds is None else bonds
    stick = min(STICK, float(radii.min()) / 2)
    count = len(atoms)
    bond_surfaces = count + np.arange(len(bonds)) if count_bonds else np.full(len(bonds), NOT_COUNTED)
    subject = open_subject(
        scene_of(atoms.positions, radii, bonds, stick),
        groups=np.concatenate([np.repeat(np.arange(count), faces_of_ball(count)), np.repeat(bond_surfaces, 2)]),
        names=[*atoms.symbols, *([BOND] * len(bonds) if count_bonds else [])],
    )
    areas = 4 * np.pi * radii**2
    if count_bonds:
        first, second = bonds.T
        length = np.linalg.norm(atoms.positions[first] - atoms.positions[second], axis=1)
        within = np.sqrt(radii**2 - stick**2)  # how far the side of a stick reaches into a ball
        areas = np.append(areas, 2 * np.pi * stick * np.maximum(length - within[first] - within[second], 0.0))
    # Tighter than a box around the sticks. Without a mesh, as the corners of the solids that stand for balls are no
    # part of a molecule: their curvature would be that of an icosahedron.
    radius_of_all = float((np.linalg.norm(atoms.positions - subject.centre, axis=1) + radii).max())
    return replace(subject, areas=areas, radius=radius_of_all, mesh=NO_MESH, shape_names=[])


def require_few(count: int, most: int = MOST_ATOMS) -> None:
    """Raise SettingsError if ``count`` atoms are more than ``most``."""
    if count > most:
        raise SettingsError(f"{count} atoms are more than {most}; cut out a smaller ball, or repeat the cell less.")
