"""Large files, made small: their content, and what processes cost."""

import sys

import numpy as np
import pytest

from benchmarks.viewpoint import large
from benchmarks.viewpoint.page import large_files as page_of_large_files
from tracer.errors import TracerError
from tracer.scene.mesh_files import read_parts
from tracer.viewpoint.atom_files import read_atoms


def test_all_meshes_are_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(large, "FACES", 200)
    meshes = []
    for suffix, write in (("ply", large.write_ply), ("stl", large.write_stl), ("glb", large.write_glb)):
        assert write(tmp_path / f"a.{suffix}", tmp_path) == "200 faces"
        meshes += read_parts(tmp_path / f"a.{suffix}")
    assert large.write_obj(tmp_path / "a.obj", tmp_path) == "200 faces"
    meshes += read_parts(tmp_path / "a.obj")
    for mesh in meshes:
        assert len(mesh.vertices) == 121
        assert mesh.vertices[mesh.faces] == pytest.approx(meshes[0].vertices[meshes[0].faces], abs=1e-6)


def test_the_molecule_has_its_atoms(tmp_path, monkeypatch):
    monkeypatch.setattr(large, "ATOMS", 30)
    lines = [
        f"{'HETATM':6}{k:5}  {name}   LIG A   1    {k:8.3f}{0:8.3f}{0:8.3f}  1.00  0.00          {name:>2}"
        for k, name in enumerate("CNO", 1)
    ]
    (tmp_path / large.PROTEIN).write_text("\n".join([*lines, "END"]) + "\n")
    assert large.write_mmcif(tmp_path / "a.cif", tmp_path) == "30 atoms"
    atoms = read_atoms(tmp_path / "a.cif")
    assert atoms.symbols == ["C", "N", "O"] * 10
    copies = atoms.positions.reshape(10, 3, 3)
    assert copies - copies[:, :1] == pytest.approx(np.array([[[0, 0, 0], [1, 0, 0], [2, 0, 0]]] * 10))
    assert len(np.unique(copies[:, 0], axis=0)) == 10


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
