"""Atoms from files of each kind, written in the test."""

from pathlib import Path

import numpy as np
import pytest

from tracer.errors import SceneError
from tracer.viewpoint.atom_files import read_atoms

SHARED = Path(__file__).parents[3] / "shared" / "molecules"

NAMES = ("alt_id", "atom_id", "comp_id", "asym_id", "seq_id")
LOOP = """data_1ABC
# a remark 'with a quote
_cell.length_a 30.0
_struct.title
;A text of lines
loop_ _atom_site.not_this 1
;
loop_
_atom_site.group_PDB
_atom_site.id
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_alt_id
_atom_site.label_comp_id
_atom_site.label_asym_id
_atom_site.label_seq_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
_atom_site.occupancy
_atom_site.pdbx_PDB_model_num
"""
ROWS = """ATOM 1 N N . MET A 1 1.0 2.0 3.0 1.00 1
ATOM 2 C "C1'" ? MET A 1 2.0(3) 2.0 3.0 1.00 1
ATOM 3 O 'O 5" "' . MET A 1 3.0 2.0 -3e0 1.00 1 # behind a row
HETATM 4 ZN ZN B LIG A 2 4.0 2.0
3.0 0.50 1
HETATM 5 ZN ZN C LIG A 2 4.5 2.0 3.0 0.50 1
HETATM 6 O O . HOH A . 5.0 2.0 3.0 1.00 1
HETATM 7 O O . HOH A . 6.0 2.0 3.0 1.00 1
ATOM 1 N N . MET A 1 9.0 2.0 3.0 1.00 2
#
loop_
_atom_type.symbol
C
"""


def written(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    return read_atoms(tmp_path / name)


def test_files(tmp_path):
    (tmp_path / "water.xyz").write_text("3\nwater\nO 0 0 0\nH 0.76 0.59 0\nH -0.76 0.59 0\n")
    water = read_atoms(tmp_path / "water.xyz")
    assert (water.symbols, water.cell) == (["O", "H", "H"], None)
    (tmp_path / "carbon.cml").write_text('<m xmlns="x"><atom id="a" elementType="C" x3="1" y3="2" z3="3"/></m>')
    assert read_atoms(tmp_path / "carbon.cml").positions.tolist() == [[1, 2, 3]]
    line = "ATOM      2  CA {}PRO A   1      30.307  38.663   5.319  1.00 40.62"
    (tmp_path / "one.pdb").write_text("\n".join([line.format(" "), line.format("B"), "ENDMDL", line.format(" ")]))
    alpha = read_atoms(tmp_path / "one.pdb")
    assert (alpha.symbols, alpha.positions.tolist()) == (["C"], [[30.307, 38.663, 5.319]])


def pdb(*atoms):
    """Return lines of a PDB file from (name, letter, residue, x, occupancy, element)."""
    return "\n".join(
        f"HETATM{k:5d} {name:<4}{letter:1}{residue:>9}    {x:8.3f}{0:8.3f}{0:8.3f}{occupancy:>6} 20.00{element:>12}"
        for k, (name, letter, residue, x, occupancy, element) in enumerate(atoms)
    )


@pytest.mark.parametrize(
    ("atoms", "kept"),
    [
        # Of which some exist only as B or C, in a residue that is two kinds of sugar.
        (
            [
                (" C1", "A", "GLC B   1", 0, 0.76, "C"),
                (" C2", "A", "GLC B   1", 1, 0.76, "C"),
                (" C1", "B", "BGC B   1", 2, 0.24, "C"),
                (" C2", "B", "BGC B   1", 3, 0.24, "C"),
                (" O9", "B", "BGC B   1", 4, 0.24, "O"),
                (" CE", "B", "LYS A   2", 5, 0.5, "C"),
                (" CE", "C", "LYS A   2", 6, 0.5, "C"),
            ],
            [0, 1, 4, 5],
        ),
        # The larger occupancy, whatever its letter and place; digits are letters as well.
        ([(" CA", "A", "LYS A   1", 0, 0.3, "C"), (" CA", "B", "LYS A   1", 1, 0.7, "C")], [1]),
        ([(" CA", "1", "LYS A   1", 0, 0.5, "C"), (" CA", "2", "LYS A   1", 1, 0.5, "C")], [0]),
        ([(" CA", " ", "LYS A   1", 0, 0.6, "C"), (" CA", "B", "LYS A   1", 1, 0.4, "C")], [0]),
        # Another chain, residue, insertion, name, or none of them: other atoms.
        ([(" CA", "A", f"LYS {chain}   1", k, 0.5, "C") for k, chain in enumerate("AB")], [0, 1]),
        ([(" CA", "A", f"LYS A   {number}", k, 0.5, "C") for k, number in enumerate("12")], [0, 1]),
        ([(" H", " ", "UNL     1", k, "", "H") for k in range(3)], [0, 1, 2]),
    ],
)
def test_alternate_places_of_an_atom_count_once(atoms, kept, tmp_path):
    found = written(tmp_path, "alternates.pdb", pdb(*atoms))
    assert found.positions[:, 0].tolist() == kept


def test_an_insertion_is_another_residue(tmp_path):
    atoms = [(" CA", "A", "LYS A  52", 0, 0.5, "C"), (" CA", "A", "LYS A  52", 1, 0.5, "C")]
    first, second = pdb(*atoms).splitlines()
    assert len(written(tmp_path, "insertion.pdb", f"{first}\n{second[:26]}A{second[27:]}\n")) == 2


def test_mmcif(tmp_path):
    """Quotes, texts, remarks, rows of several lines, alternates, atoms without a number, and the first model."""
    for name in ("a.cif", "a.mmcif"):
        found = written(tmp_path, name, LOOP + ROWS)
        assert found.symbols == ["N", "C", "O", "Zn", "O", "O"]
        assert found.positions[:, 0].tolist() == [1, 2, 3, 4, 5, 6]
        assert found.positions[2].tolist() == [3, 2, -3]
        assert found.cell is None


def test_mmcif_of_one_atom(tmp_path):
    pairs = "data_x\n" + "".join(
        f"_atom_site.{name} {value}\n"
        for name, value in (
            *(("id", 1), ("Type_Symbol", "he"), ("Cartn_x", 1), ("Cartn_y", 2), ("Cartn_z", 3)),
            *((f"label_{item}", "." if item == "alt_id" else 1) for item in NAMES),
        )
    )
    found = written(tmp_path, "one.cif", pairs + "_entity.id 1\n" + pairs.replace("data_x", "data_y"))
    assert (found.symbols, found.positions.tolist()) == (["He"], [[1, 2, 3]])


@pytest.mark.parametrize("gap", ["", "\n", "\n  \n\n"])
def test_the_last_frame_of_an_xyz_file(gap, tmp_path):
    frames = ["2\nfirst\nH 1 0 0\nH 0 0 0\n", "1\n\nHe 5 0 0\n", "2\nlast\nH 2 0 0\nC 1 0 0\n"]
    found = written(tmp_path, "frames.xyz", gap.join(frames) + gap)
    assert (found.symbols, found.positions[:, 0].tolist()) == (["H", "C"], [2, 1])


def test_elements_may_be_atomic_numbers(tmp_path):
    found = written(tmp_path, "numbers.xyz", "3\n\n6 0 0 0\n 8 1.2 0 0\nH 0 1 0\n")
    assert found.symbols == ["C", "O", "H"]
    lattice = 'Lattice="3 0 0 0 3 0 0 0 3" pbc="T T T" Properties='
    found = written(tmp_path, "first.extxyz", f"1\n{lattice}species:S:1:pos:R:3\n79 1 2 3\n")
    assert (found.symbols, found.cell.tolist()) == (["Au"], (3 * np.eye(3)).tolist())
    found = written(tmp_path, "second.extxyz", f"1\n{lattice}pos:R:3:species:S:1\n1 2 3 Au\n")
    assert (found.symbols, found.positions.tolist()) == (["Au"], [[1, 2, 3]])


@pytest.mark.skipif(not SHARED.is_dir(), reason="the public molecules are not here")
@pytest.mark.parametrize(
    ("name", "count", "repeats"),
    [("C60-buckminsterfullerene.cml", 60, False), ("C-Graphite.cif", 4, True), ("1hpv.pdb", 1631, False)],
)
def test_public_files(name, count, repeats):
    atoms = read_atoms(SHARED / name)
    assert len(atoms) == count
    assert (atoms.cell is not None) == repeats
    assert set(atoms.symbols) <= {"C", "N", "O", "S", "H"}


def test_what_is_no_molecule(tmp_path):
    with pytest.raises(SceneError, match="no molecule file"):
        read_atoms(tmp_path / "none.xyz")
    for name, text in (("a.xyz", "0\n\n"), ("b.cml", "<m/>"), ("c.pdb", "END\n")):
        (tmp_path / name).write_text(text)
        with pytest.raises(SceneError, match=r"has no atoms|cannot|not a molecule"):
            read_atoms(tmp_path / name)
    said = {
        "k.xyz": ("1\n\n200 0 0 0\n", "no element 200"),
        "l.xyz": ("1\n\nC 0 0 0\nand more\n", "line 4 should be a number of atoms and is 'and more'"),
        "m.cif": (LOOP.replace("_y\n", "_w\n") + ROWS, "has no _atom_site.Cartn_y"),
        "n.cif": (LOOP + "ATOM 1 N\n", "Wrong number of values in loop"),
        "h.xyz": ("2\n\nQq 0 0 0\nC 1 0 0\n", "no element 'Qq'"),
        "i.xyz": ("999999999999\n\nC 0 0 0\n", "has 2 lines"),
        "j.cif": ("data_x\n_cell_length_a 3\n", "ends before its atoms"),
    }
    for name, (text, sentence) in said.items():
        (tmp_path / name).write_text(text)
        with pytest.raises(SceneError, match=sentence):
            read_atoms(tmp_path / name)
    for name in ("d.xyz", "e.cif", "f.cml", "g.pdb"):
        (tmp_path / name).write_text("ATOM  hello world\n")
        with pytest.raises(SceneError, match=r"not a molecule|no atoms"):
            read_atoms(tmp_path / name)
