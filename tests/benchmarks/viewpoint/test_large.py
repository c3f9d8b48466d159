"""Large files, made small: their content, and what processes cost."""

import sys

import numpy as np
import pytest

from benchmarks.viewpoint import large
from benchmarks.viewpoint.page import large_files as page_of_large_files
from tracer.errors import TracerError
from tracer.scene.mesh_files import read_parts
from tracer.viewpoint.atom_files import read_atoms


def test_both_meshes_are_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(large, "FACES", 200)
    assert large.write_ply(tmp_path / "a.ply") == large.write_stl(tmp_path / "a.stl") == "200 faces"
    (ply,), (stl,) = read_parts(tmp_path / "a.ply"), read_parts(tmp_path / "a.stl")
    assert len(ply.vertices) == len(stl.vertices) == 121
    assert np.array_equal(ply.vertices[ply.faces], stl.vertices[stl.faces])


def test_the_molecule_has_its_atoms(tmp_path, monkeypatch):
    monkeypatch.setattr(large, "ATOMS", 30)
    assert large.write_xyz(tmp_path / "a.xyz") == "30 atoms"
    atoms = read_atoms(tmp_path / "a.xyz")
    assert set(atoms.symbols) == {"C", "N", "O"}
    assert np.ptp(atoms.positions, axis=0).max() < 4 * large.SPACING


def test_the_memory_of_a_process_is_its_own():
    seconds, memory = large.cost_of([sys.executable, "-c", "x = b'1' * 200_000_000"])
    _, less = large.cost_of([sys.executable, "-c", "pass"])
    assert seconds > 0
    assert 180e6 < memory - less < 220e6
    with pytest.raises(TracerError, match="failed"):
        large.cost_of([sys.executable, "-c", "raise SystemExit(3)"])


def test_the_table():
    row = {"file": "a.ply", "size": "5 faces", "megabytes": 97.4, "command": "render --spp 16", "seconds": 12.3}
    assert "| a.ply, 97 MB | 5 faces | `tracer render --spp 16` | 12 | 1.5 |" in page_of_large_files(
        [{**row, "gigabytes": 1.53}]
    )
