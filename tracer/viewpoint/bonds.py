"""Bonds between atoms, from their distances alone, as most files of atoms have no bonds.

Two atoms are bonded if they are at most the sum of their covalent radii and 0.4 Angstrom apart, the rule of the
Cambridge Structural Database (E. Meng and R. Lewis, "Determination of molecular topology and atomic hybridization
states from heavy atom coordinates", Journal of Computational Chemistry 12, 1991). Of a crystal, bonds are found in the
finite piece that is looked at, so that none leads to an atom that is not there.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from tracer.core.arrays import Integers
from tracer.viewpoint.atom_files import Atoms
from tracer.viewpoint.elements import covalent_radii

SLACK = 0.4
"""Bonds are at most this much longer than the sum of the covalent radii, in Angstrom."""
NEAREST = 0.4
"""Atoms that are not farther apart than this, in Angstrom, are alternate places of one atom, not bonded atoms."""


def find_bonds(atoms: Atoms) -> Integers:
    """Return the bonds (B, 2): numbers of two atoms, the smaller first, in ascending order."""
    radii = covalent_radii(atoms.symbols)
    pairs = cKDTree(atoms.positions).query_pairs(2 * radii.max() + SLACK, output_type="ndarray").astype(np.int64)
    lengths = np.linalg.norm(atoms.positions[pairs[:, 0]] - atoms.positions[pairs[:, 1]], axis=1)
    pairs = pairs[(lengths > NEAREST) & (lengths <= radii[pairs].sum(axis=1) + SLACK)]
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
