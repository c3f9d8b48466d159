"""Models, biological assemblies and old files, written in the test."""

import numpy as np
import pytest

from tracer.errors import SceneError, SettingsError
from tracer.viewpoint.atom_files import read_atoms
from tracer.viewpoint.biomolecules import Part, rank_within

ATOM = "ATOM  {:5d}  CA {}LYS {}   1    {:8.3f}   2.000   3.000  {:4.2f} 20.00           C\n"


def written(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    return tmp_path / name


@pytest.fixture
def models(tmp_path):
    """Write three models, numbered 1, 2 and 5, of one atom each at x = 1, 2 and 5."""
    text = "".join(f"MODEL     {k:4d}\n{ATOM.format(1, ' ', 'A', k, 1.0)}ENDMDL\n" for k in (1, 2, 5))
    return written(tmp_path, "models.pdb", text + "END\n")


def test_the_first_model_is_taken_and_said(models):
    first = read_atoms(models)
    assert first.positions.tolist() == [[1, 2, 3]]
    assert first.remark == f"'{models}' has 3 models, and this is the first; --model takes another."
    other = read_atoms(models, Part(model="5"))
    assert other.positions.tolist() == [[5, 2, 3]]
    assert other.remark == ""


def test_a_model_that_does_not_exist_is_said_with_those_that_do(models):
    with pytest.raises(SettingsError, match=r"has no model 3; it has 1, 2, 5\.$"):
        read_atoms(models, Part(model="3"))
    with pytest.raises(SettingsError, match=r"has no assembly 1: it has none\.$"):
        read_atoms(models, Part(assembly="1"))


REMARK = """REMARK 350 BIOMOLECULE: 1
REMARK 350 APPLY THE FOLLOWING TO CHAINS: A
REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000
REMARK 350   BIOMT1   2 -1.000000  0.000000  0.000000       10.00000
REMARK 350   BIOMT2   2  0.000000 -1.000000  0.000000        0.00000
REMARK 350   BIOMT3   2  0.000000  0.000000  1.000000        0.00000
"""
MMCIF = """data_x
loop_
_atom_site.id
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_comp_id
_atom_site.label_asym_id
_atom_site.label_seq_id
_atom_site.label_alt_id
_atom_site.occupancy
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
1 C CA LYS A 1 A 0.3 7 2 3
2 C CA LYS A 1 B 0.7 1 2 3
3 C CA LYS B 1 . 1.0 5 2 3
_pdbx_struct_assembly.id 1
_pdbx_struct_assembly.details ?
_pdbx_struct_assembly.method_details ?
_pdbx_struct_assembly.oligomeric_details ?
_pdbx_struct_assembly.oligomeric_count ?
loop_
_pdbx_struct_assembly_gen.assembly_id
_pdbx_struct_assembly_gen.oper_expression
_pdbx_struct_assembly_gen.asym_id_list
1 1,2 A
loop_
_pdbx_struct_oper_list.id
_pdbx_struct_oper_list.type
_pdbx_struct_oper_list.matrix[1][1]
_pdbx_struct_oper_list.matrix[1][2]
_pdbx_struct_oper_list.matrix[1][3]
_pdbx_struct_oper_list.vector[1]
_pdbx_struct_oper_list.matrix[2][1]
_pdbx_struct_oper_list.matrix[2][2]
_pdbx_struct_oper_list.matrix[2][3]
_pdbx_struct_oper_list.vector[2]
_pdbx_struct_oper_list.matrix[3][1]
_pdbx_struct_oper_list.matrix[3][2]
_pdbx_struct_oper_list.matrix[3][3]
_pdbx_struct_oper_list.vector[3]
1 'identity operation' 1 0 0 0 0 1 0 0 0 0 1 0
2 . -1 0 0 10 0 -1 0 0 0 0 1 0
"""


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "a.pdb",
            REMARK
            + ATOM.format(1, "A", "A", 7, 0.3)
            + ATOM.format(2, "B", "A", 1, 0.7)
            + ATOM.format(3, " ", "B", 5, 1),
        ),
        ("a.cif", MMCIF),
    ],
)
def test_an_assembly_copies_the_likelier_places_of_its_chains(name, text, tmp_path):
    path = written(tmp_path, name, text)
    assert read_atoms(path).positions.tolist() == [[1, 2, 3], [5, 2, 3]]
    found = read_atoms(path, Part(assembly="1")).positions
    assert found[np.argsort(found[:, 0])].tolist() == [[1, 2, 3], [9, -2, 3]]
    with pytest.raises(SettingsError, match=r"has no assembly 9; it has 1\.$"):
        read_atoms(path, Part(assembly="9"))


def test_other_files_have_no_models(tmp_path):
    path = written(tmp_path, "a.xyz", "1\n\nC 0 0 0\n")
    with pytest.raises(SettingsError, match="PDB and mmCIF files have models"):
        read_atoms(path, Part(model="1"))


def test_old_files_number_their_lines_where_new_ones_have_the_element(tmp_path):
    lines = [
        "ATOM      1  CA  PRO A   1      30.307  38.663   5.319  1.00 40.62      1HPV  68",
        "ATOM      2 HG11 VAL A   2      31.307  38.663   5.319  1.00 40.62      1HPV 169",
        "HETATM    3 CA    CA A   3      32.307  38.663   5.319  1.00 40.62      1HPV1170",
    ]
    found = read_atoms(written(tmp_path, "old.pdb", "\n".join(lines) + "\n"))
    assert found.symbols == ["C", "H", "Ca"]
    assert found.positions[:, 0].tolist() == [30.307, 31.307, 32.307]


def test_a_line_that_is_cut_off_is_said(tmp_path):
    with pytest.raises(SceneError, match=r"too short to be correct\.$"):
        read_atoms(written(tmp_path, "cut.pdb", "ATOM  hello world\n"))


def test_ranks_within_groups():
    assert rank_within(np.array([4, 2, 4, 4, 2])).tolist() == [0, 0, 1, 2, 1]
