"""The report on views, with everything made small."""

import json
import shutil

import mitsuba as mi
import numpy as np
import pytest

from benchmarks.viewpoint import report as everything
from benchmarks.viewpoint.page import search_table
from tracer.errors import SceneError

XYZ = "3\nwater\nO 0 0 0\nH 0.76 0.59 0\nH -0.76 0.59 0\n"
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"
SCENE = '<scene version="3.0.0"><shape type="sphere"/><shape type="disk"/></scene>'


@pytest.fixture
def public(tmp_path):
    for folder in ("meshes", "molecules", "scenes"):
        (tmp_path / folder).mkdir()
    cube = mi.load_dict({"type": "cube"})
    cube.write_ply(str(tmp_path / "meshes" / "bunny.ply"))
    for name in ("spot.obj", "teapot.ply"):
        if name.endswith("ply"):
            shutil.copy(tmp_path / "meshes" / "bunny.ply", tmp_path / "meshes" / name)
        else:
            (tmp_path / "meshes" / name).write_text(
                "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"
            )
    (tmp_path / "molecules" / "water.xyz").write_text(XYZ)
    (tmp_path / "scenes" / "two.xml").write_text(SCENE)
    return tmp_path


@pytest.mark.slow
def test_the_report(public, tmp_path, monkeypatch):
    small = {
        "MESHES": dict.fromkeys(["bunny.ply", "spot.obj", "teapot.ply"], (0.0, 1.0, 0.0)),
        "CRYSTALS": (),
        "MOLECULES": ("water.xyz",),
        "RATE_SIDE": 32,
        "RATE_LEVEL": 1,
        "SEARCH_SIDE": 16,
        "COVER_SIDE": 32,
        "TRUTH_SIDE": 64,
        "SEARCH_LEVEL": 0,
        "SHOWN_MEASURES": ("entropy",),
        "NUMBERS_OF_RAYS": (100, 400),
        "SEEDS": 3,
        "FEW_SURFACES": "two.xml",
    }
    for name, value in small.items():
        monkeypatch.setattr(everything, name, value)
    monkeypatch.setattr(everything.measures, "names", lambda: ["entropy", "kullback_leibler", "curvature_entropy"])
    out = tmp_path / "out"
    out.mkdir()
    headings = []
    everything.everything(public, public / "scenes", out, lambda text, done, total: headings.append(text))
    page = (out / "results.md").read_text()
    found = json.loads((out / "results.json").read_text())
    assert list(found) == [
        "Rate",
        "Searches",
        "View sets",
        *("Convergence of the fast estimate", "Molecules", "Pictures"),
    ]
    assert list(found)[3:] == ["Convergence of the fast estimate", "Molecules", "Pictures"]
    assert all(heading in headings for heading in found)
    assert len(found["Searches"]) == 3 * 3 + 2  # no curvature without a mesh
    assert all(0 <= row["reached"][search] <= 1 + 1e-9 for row in found["Searches"] for search in row["reached"])
    for link in [part.split(")")[0] for part in page.split("](")[1:]]:
        assert (out / link).is_file(), link
    assert not list(out.glob("*/frame*.png"))


def test_the_table_of_searches():
    def row(subject, measure, paper):
        reached = {"paper": paper, "octants": 1.0, "exhaustive": 1.0}
        return {"subject": subject, "measure": measure, "reached": reached, "views": dict.fromkeys(reached, 10)}

    lines = search_table([row("a", "entropy", 0.5), row("b", "entropy", 0.9), row("a", "visible", 1.0)])
    assert "| entropy | 0.70 (0.50), 10 | 1.00 (1.00), 10 | 1.00 (1.00), 10 |" in lines
    assert lines[-1].startswith("| **all** | 0.80 (0.50), 10 |")


def test_it_can_be_stopped(public, tmp_path, monkeypatch):
    monkeypatch.setattr(everything, "MESHES", {"bunny.ply": (0.0, 1.0, 0.0)})
    with pytest.raises(KeyboardInterrupt):
        everything.everything(public, public / "none", tmp_path, lambda *_: False)


def test_a_mesh_that_is_not_there(tmp_path):
    (tmp_path / "meshes").mkdir()
    with pytest.raises(SceneError, match="no mesh"):
        everything.everything(tmp_path, tmp_path, tmp_path, lambda *_: None)
    assert np.all([not path.is_file() for path in tmp_path.iterdir()])
