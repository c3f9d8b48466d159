"""Bonds against ASE's neighbour list, and against what chemists know."""

import ase.build
import numpy as np
import pytest
from ase.neighborlist import natural_cutoffs, neighbor_list

from tracer.viewpoint.atom_files import Atoms
from tracer.viewpoint.bonds import NEAREST, SLACK, find_bonds


def atoms_of(structure):
    return Atoms(structure.get_chemical_symbols(), structure.positions)


@pytest.mark.parametrize(
    ("name", "bonds"),
    [("H2", 1), ("H2O", 2), ("CH4", 4), ("C2H6", 7), ("C2H2", 3), ("C6H6", 12), ("SO2", 2), ("CH3SH", 5), ("NaCl", 1)],
)
def test_molecules_have_the_bonds_that_chemists_draw(name, bonds):
    assert len(find_bonds(atoms_of(ase.build.molecule(name)))) == bonds


def test_atoms_within_diamond_have_four_bonds_and_none_leads_out_of_the_piece():
    piece = ase.build.bulk("C", "diamond", 3.567, cubic=True).repeat((3, 3, 3))
    found = find_bonds(atoms_of(piece))
    counts = np.bincount(found.ravel(), minlength=len(piece))
    inner = np.all((piece.positions > 1.6) & (piece.positions < 9.1), axis=1)
    assert set(counts[inner]) == {4}
    assert counts.min() < 4
    assert np.linalg.norm(piece.positions[found[:, 0]] - piece.positions[found[:, 1]], axis=1).max() < 1.6


def test_the_same_as_the_neighbour_list_of_ase():
    generator = np.random.default_rng(3)
    symbols = generator.choice(["H", "C", "O", "S", "Zn"], 300).tolist()
    atoms = Atoms(symbols, 12 * generator.random((300, 3)))
    structure = ase.Atoms(symbols, atoms.positions)
    cutoffs = [radius + SLACK / 2 for radius in natural_cutoffs(structure)]
    first, second, distance = neighbor_list("ijd", structure, cutoffs)
    chosen = (first < second) & (distance > NEAREST)
    expected = sorted(zip(first[chosen].tolist(), second[chosen].tolist(), strict=True))
    assert len(expected) > 100
    assert find_bonds(atoms).tolist() == [list(pair) for pair in expected]


def test_one_atom_has_no_bond():
    assert find_bonds(Atoms(["C"], np.zeros((1, 3)))).shape == (0, 2)
