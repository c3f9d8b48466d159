"""The report on views, with everything made small."""

import json
import shutil

import mitsuba as mi
import numpy as np
import pytest

from benchmarks import harness
from benchmarks.viewpoint import large, report
from benchmarks.viewpoint.lit import content, lit_views
from benchmarks.viewpoint.page import lit_views as page_of_light
from benchmarks.viewpoint.page import searches, view_sets
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
        monkeypatch.setattr(report, name, value)
    monkeypatch.setattr(report.measures, "names", lambda: ["entropy", "kullback_leibler", "curvature_entropy"])
    monkeypatch.setattr(large, "FACES", 200)
    monkeypatch.setattr(large, "FILES", {"a.ply": (large.write_ply, ("view best --level 2",))})
    out = tmp_path / "out"
    out.mkdir()
    steps = []
    monkeypatch.setattr(harness, "bundled_scenes", lambda: [public / "scenes" / "two.xml"])
    report.report(out, lambda *step: steps.append(step), public)
    page = (out / "results.md").read_text()
    found = json.loads((out / "results.json").read_text())
    assert list(found) == [
        "Rate",
        "Searches",
        "View sets",
        "Convergence of the fast estimate",
        "Light",
        "Molecules",
        "Pictures",
        "Large files",
    ]
    assert [done for _, done, _ in steps] == list(range(len(steps)))
    assert {total for _, _, total in steps} == {len(steps)}
    assert len(found["Searches"]) == 3 * 3 + 2  # no curvature without a mesh
    assert all(0 <= row["reached"][search] <= 1 + 1e-9 for row in found["Searches"] for search in row["reached"])
    for link in [part.split(")")[0] for part in page.split("](")[1:]]:
        assert (out / link).is_file(), link
    assert not list(out.glob("*/frame*.png"))
    (out / "results.json").write_text(json.dumps({name: found[name] for name in found if name != "Molecules"}))
    steps.clear()
    report.report(out, lambda *step: steps.append(step), public, resume=True)
    assert [text for text, _, _ in steps] == ["molecules: water.xyz"]  # the rest is kept
    assert list(json.loads((out / "results.json").read_text())) == list(found)


def test_the_table_of_searches():
    def row(subject, measure, paper):
        reached = {"paper": paper, "octants": 1.0, "exhaustive": 1.0}
        return {"subject": subject, "measure": measure, "reached": reached, "views": dict.fromkeys(reached, 10)}

    text = searches([row("a", "entropy", 0.5), row("b", "entropy", 0.9), row("a", "visible", 1.0)])
    assert "| entropy | 0.70 (0.50), 10 | 1.00 (1.00), 10 | 1.00 (1.00), 10 |\n" in text
    assert text.splitlines()[-1].startswith("| **all** | 0.80 (0.50), 10 |")


@pytest.mark.parametrize(
    ("reached", "least", "fewest"), [(5, 5, "5"), (6, 4, "4 to 6"), (0, 3, "at least 3"), (0, 0, "at least 0")]
)
def test_a_set_that_was_not_found_in_time_is_not_said_to_exist(reached, least, fewest):
    row = {"subject": "a", "enough": 0.9, "found exactly": reached, "least": least}
    assert view_sets([{**row, "entropy": 7, "area": 8, "divergence": 9}]).splitlines()[-1] == (
        f"| a | 90 % | 7 | 8 | 9 | {fewest} |"
    )


def test_it_can_be_stopped(public, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "MESHES", {"bunny.ply": (0.0, 1.0, 0.0)})
    with pytest.raises(KeyboardInterrupt):
        report.report(tmp_path, lambda *_: False, public)


def test_a_mesh_that_is_not_there(tmp_path):
    (tmp_path / "meshes").mkdir()
    with pytest.raises(SceneError, match="no mesh"):
        report.report(tmp_path, lambda *_: None, tmp_path)
    assert np.all([not path.is_file() for path in tmp_path.iterdir()])


def test_a_picture_is_judged_by_its_histogram():
    """Half black, half white: one bit, half of it dark and half burnt out. All grey: nothing."""
    halves = np.zeros((8, 8, 3))
    halves[:4] = 1
    assert content(halves) == {"entropy": pytest.approx(1.0), "dark": 0.5, "burnt out": 0.5}
    assert content(np.full((8, 8, 3), 0.5)) == {"entropy": pytest.approx(0.0), "dark": 0.0, "burnt out": 0.0}


def test_the_mean_is_also_told_without_the_scene_of_the_largest_gain():
    def row(scene, *entropies):
        ways = zip(("geometry", "light"), entropies, strict=True)
        return {"scene": scene, **{way: {"entropy": bits, "dark": 0.2, "burnt out": 0.1} for way, bits in ways}}

    text = page_of_light([row("a", 2.0, 2.5), row("b", 3.0, 2.8), row("black", -0.0, 2.4), row("c", 1.0, 1.01)])
    assert "on 2 of 4 scenes, and the smaller on 1." in text
    assert "| black | 0.00 | 2.40 |" in text
    assert "| **mean without black** | 2.00 | 2.10 | 20 % | 20 % | 10 % | 10 % |" in text


@pytest.mark.slow
def test_light_shows_more_than_geometry_alone(tmp_path):
    """Twenty balls in the dark on one side of a wall, three in the light on the other."""
    balls = "".join(
        f'<shape type="sphere"><point name="center" x="{x}" y="{y}" z="{0.2 * k}"/><float name="radius" value="0.1"/>'
        "</shape>"
        for k, (x, y) in enumerate([(-1.5, 0.2 * k - 2) for k in range(20)] + [(1.5, -1), (1.5, 0), (1.5, 1)])
    )
    wall = (
        '<shape type="cube"><transform name="to_world"><scale x="0.05" y="4" z="6"/></transform></shape>'
        '<emitter type="point"><point name="position" x="8" y="0" z="2"/><rgb name="intensity" value="200"/></emitter>'
    )
    scene = tmp_path / "scene.xml"
    scene.write_text(f'<scene version="3.0.0"><integrator type="path"/>{wall}{balls}</scene>')
    (row,) = lit_views({"wall": scene}, tmp_path, lambda *_: None)
    assert row["light"]["dark"] < row["geometry"]["dark"] - 0.1
    assert row["light"]["entropy"] > row["geometry"]["entropy"]
    assert (tmp_path / "light.png").is_file()
    assert "1 of 1 scenes" in page_of_light([row])
