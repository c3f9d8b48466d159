"""Two molecules: what one sees of the other from the points of its surface (the paper, section 5).

The surface of a molecule is where the centre of a water molecule can be: A. Shrake and J. Rupley, "Environment and
exposure to solvent of protein atoms", Journal of Molecular Biology 79, 1973. Lengths are in Angstrom.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tracer.core.arrays import Floats, Integers, evenly_chosen
from tracer.core.sphere import icosphere
from tracer.errors import SceneError, SettingsError
from tracer.viewpoint import measures, molecules
from tracer.viewpoint.atom_files import Atoms
from tracer.viewpoint.direction_measure import SHARE
from tracer.viewpoint.elements import van_der_waals_radii
from tracer.viewpoint.item_buffer import Rays, at
from tracer.viewpoint.lens import WholeSphere
from tracer.viewpoint.surfaces import Subject
from tracer.viewpoint.survey import better, survey

PROBE = 1.4
"""Radius of a water molecule."""
POINTS_LEVEL = 1
"""An atom has a point of the surface at each of the 42 corners of an icosphere of this level, unless it is covered."""
MOST_POINTS = 4096
"""From at most this many points views are measured; of more, evenly spread ones."""
TOUCH = 1e-9
"""A point that is less than this within a ball is on it."""
SIDE = 64
"""A view has the square of this many rays, into all directions."""


@dataclass(frozen=True)
class Pair:
    """Two molecules in the same coordinates."""

    seen: Atoms
    seen_from: Atoms


@dataclass(frozen=True)
class Sites:
    """Points of the surface of one molecule, and how good the views of the other are from there."""

    points: Floats
    """(P, 3)."""
    atom: Integers
    """(P,): the atom of the molecule that each point belongs to."""
    values: Floats
    """(P,): larger if better; -inf where nothing of the other molecule is seen."""

    def best_of_atoms(self) -> Integers:
        """Return the numbers of the points that are the best of their atoms, best first."""
        order = np.argsort(-self.values, kind="stable")
        first = np.unique(self.atom[order], return_index=True)[1]
        return order[np.sort(first)]


def open_pair(seen: Atoms, seen_from: Atoms, radius: float | None = None) -> Subject:
    """Return two molecules as a subject in which the second one hides, and does not count.

    ``radius``: of all balls; None: van der Waals radii, as molecules have in each other's eyes.
    """
    atoms = Atoms([*seen.symbols, *seen_from.symbols], np.concatenate([seen.positions, seen_from.positions]))
    radii = van_der_waals_radii(atoms.symbols) if radius is None else radius
    weights = np.repeat([1.0, 0.0], [len(seen), len(seen_from)])
    return replace(molecules.open_molecule(atoms, radii), weights=weights)


def surface_points(atoms: Atoms) -> tuple[Floats, Integers]:
    """Return points (P, 3) of the surface of a molecule, and the atom (P,) of each."""
    reach = van_der_waals_radii(atoms.symbols) + PROBE
    directions = icosphere(POINTS_LEVEL)[0]
    points = (atoms.positions[:, None] + reach[:, None, None] * directions).reshape(-1, 3)
    owner = np.repeat(np.arange(len(atoms)), len(directions))
    free = ~is_within(points, atoms.positions, reach, owner)
    return points[free], owner[free]


def is_within(points: Floats, centres: Floats, radii: Floats, own: Integers | None = None) -> NDArray[np.bool_]:
    """Return which points (P, 3) are within any ball; ``own`` (P,): the ball of each that is not asked."""
    inside = np.zeros(len(points), bool)
    tree = cKDTree(points)
    for k, near in enumerate(tree.query_ball_point(centres, radii - TOUCH)):
        within = np.asarray(near, np.int64)
        inside[within if own is None else within[own[within] != k]] = True
    return inside


def find_sites(
    seen: Atoms, seen_from: Atoms, subject: Subject, name: str, good: measures.Best, background: bool = True
) -> Sites:
    """Return the views of ``seen`` from the surface of ``seen_from``; ``subject``: see ``open_pair``.

    Raises SettingsError for a measure that needs views as images, SceneError if the molecules leave no point free.
    """
    if {"picture", "neighbours"} & set(measures.get(name).needs):
        raise SettingsError(f"'{name}' needs views as images, and from a surface all directions are seen; use another.")
    points, atom = surface_points(seen_from)
    free = ~is_within(points, seen.positions, van_der_waals_radii(seen.symbols))
    points, atom = points[free], atom[free]
    if not len(points):
        raise SceneError("The molecules fill each other: no point of the surface of the second one is free.")
    chosen = evenly_chosen(len(points), MOST_POINTS)
    points, atom = points[chosen], atom[chosen]
    values = survey(subject, at(points), WholeSphere(), Rays(side=SIDE), [name, SHARE], background=background)
    return Sites(points, atom, better(values[name], values[SHARE] > 0, good))
