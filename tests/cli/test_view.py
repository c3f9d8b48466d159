"""Commands ``view ...``: what they write and say."""

import csv
import json

import mitsuba as mi
import numpy as np
import pytest
from PIL import Image

from cli.views import FEW, SCENE, call, names_in
from tracer.errors import TracerError
from tracer.viewpoint import measures


def picture(path):
    with Image.open(path) as opened:
        return np.array(opened.convert("RGB"), float) / 255


@pytest.mark.slow
def test_measure(scene, tmp_path, monkeypatch):
    monkeypatch.setattr("tracer.viewpoint.reports.measure.SHOWN", 1)  # to draw takes longest
    said = call("measure", scene, "-o", tmp_path / "out", "--level", 1, "--side", 32)
    names = names_in(tmp_path / "out")
    assert {name.partition("-")[0].partition(".")[0] for name in names} == {"best_and_worst", "measures", "views"}
    for name in names:
        height, width, _ = picture(tmp_path / "out" / name).shape if name.endswith(".png") else (1, 1, 1)
        assert max(width / 1600, height / 1000) <= 1
    with open(tmp_path / "out" / "views.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 42
    assert set(rows[0]) == {"x", "y", "z", *measures.names()}
    assert "entropy" in said
    assert picture(tmp_path / "out" / "best_and_worst.png").std() > 0.02


def test_some_measures_of_surfaces_of_a_kind(scene, tmp_path):
    call("measure", scene, "-o", tmp_path / "out", "--level", 0, "-m", "visible", "--surfaces", "shape", *FEW)
    with open(tmp_path / "out" / "views.csv", newline="") as file:
        values = {float(row["visible"]) for row in csv.DictReader(file)}
    assert values <= {1, 2}


@pytest.mark.parametrize("more", [["--weight", "ball=5"], ["--by-light"]])
def test_all_measures_that_weights_allow(more, scene, tmp_path, monkeypatch):
    monkeypatch.setattr("tracer.viewpoint.reports.measure.SHOWN", 1)  # to draw takes longest
    names = ["curvature_entropy", "depth_stability", "maximum_depth", "visible"]
    monkeypatch.setattr("tracer.viewpoint.measures.names", lambda: names)
    call("measure", scene, "-o", tmp_path / "out", "--level", 0, *more, *FEW)
    with open(tmp_path / "out" / "views.csv", newline="") as file:
        assert set(next(csv.DictReader(file))) == {"x", "y", "z", "visible"}


def test_best_writes_a_camera_that_mitsuba_sees_the_same_with(scene, tmp_path):
    said = call("best", scene, "-o", tmp_path / "out", "--level", 1, "--side", 64)
    assert all(search in said for search in ("paper", "octants", "exhaustive"))
    assert names_in(tmp_path / "out") == ["best.json", "best.png", "camera.xml", "sphere.png"]
    report = json.loads((tmp_path / "out" / "best.json").read_text())
    sensor = mi.load_file(str(tmp_path / "out" / "camera.xml")).sensors()[0]
    assert np.array(sensor.world_transform().translation()).ravel() == pytest.approx(report["eye"], rel=1e-5)
    film = mi.load_dict({"type": "hdrfilm", "width": 512, "height": 512, "rfilter": {"type": "box"}})
    fov = float(mi.traverse(sensor)["x_fov"][0])
    place = mi.ScalarTransform4f(np.array(sensor.world_transform().matrix).reshape(4, 4))
    again = mi.load_dict({"type": "perspective", "fov": fov, "film": film, "to_world": place})
    depth = mi.load_dict({"type": "depth"})
    seen = mi.render(mi.load_file(str(scene)), sensor=again, integrator=depth, spp=1).numpy()[..., 0] > 0
    shown = picture(tmp_path / "out" / "best.png")
    assert np.mean(seen != (np.abs(shown - shown[0, 0]).max(axis=-1) > 0.02)) < 0.01


def test_tour_makes_a_film(scene, tmp_path):
    out = tmp_path / "out"
    call("tour", scene, "-o", out, "--steps", 3, "--frames", 5, "--size", 48, *FEW)
    assert names_in(out) == [
        "cameras.xml",
        *(f"frame{k:04d}.png" for k in range(5)),
        "path.csv",
        "path.png",
        "tour.webp",
    ]
    with Image.open(out / "tour.webp") as film:
        assert film.is_animated
        assert film.n_frames == 8  # there and back
        assert film.size == (48, 48)
    assert len(mi.load_file(str(out / "cameras.xml")).sensors()) == 5
    assert not np.array_equal(picture(out / "frame0000.png"), picture(out / "frame0004.png"))


def test_a_loop_has_each_picture_once(scene, tmp_path):
    call("tour", scene, "-o", tmp_path / "out", "--steps", 8, "--frames", 6, "--size", 32, "--loop", *FEW)
    with Image.open(tmp_path / "out" / "tour.webp") as film:
        assert film.n_frames == 6


def test_tour_makes_a_video(scene, tmp_path):
    few = ["--steps", 2, "--frames", 3, "--size", 33, "--film", "turn.mp4"]
    call("tour", scene, "-o", tmp_path / "out", *few, *FEW)
    assert (tmp_path / "out" / "turn.mp4").read_bytes()[4:8] == b"ftyp"
    assert not (tmp_path / "out" / "tour.webp").exists()


def test_a_shorter_tour_leaves_no_frames_of_a_longer_one(scene, tmp_path):
    for frames in (4, 2):
        few = ["--steps", 2, "--frames", frames, "--size", 16, "--overwrite", *FEW]
        call("tour", scene, "-o", tmp_path / "out", *few)
    frames = [name for name in names_in(tmp_path / "out") if name.startswith("frame")]
    assert frames == ["frame0000.png", "frame0001.png"]


def test_map_through_the_scenes_camera(scene, tmp_path):
    said = call("map", scene, "-o", tmp_path / "out", "--blocks", 8, "--level", 1, "--side", 64)
    assert "kullback_leibler" in said
    assert names_in(tmp_path / "out") == ["blocks.csv", "map.png", "triangles.csv"]
    with open(tmp_path / "out" / "blocks.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 8 * 6  # the film is 768 x 576
    entropy = np.array([float(row["entropy"]) for row in rows]).reshape(6, 8)
    assert entropy[[0, -1]].max() == 0  # nothing is at the edge
    assert entropy.max() > 0.5
    with open(tmp_path / "out" / "triangles.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert sum(float(row["steradians"]) for row in rows) == pytest.approx(4 * np.pi)
    ahead = [float(row["z"]) < 0 for row in rows]
    assert not any(float(row["entropy"]) for row, front in zip(rows, ahead, strict=True) if not front)
    assert picture(tmp_path / "out" / "map.png").std() > 0.02


def test_map_from_elsewhere(scene, tmp_path):
    few = ["--blocks", 4, "--level", 0, "--kind", "distinct", *FEW]
    call("map", scene, "-o", tmp_path / "out", "--from", 0, 0, 0, "--centre", 0, 0, 1, *few)
    with open(tmp_path / "out" / "triangles.csv", newline="") as file:
        assert all(float(row["distinct"]) > 1 for row in csv.DictReader(file))  # inside the cube


def test_the_fast_way_has_a_standard_error(scene, tmp_path, monkeypatch):
    monkeypatch.setattr("tracer.viewpoint.reports.measure.SHOWN", 1)  # to draw takes longest
    monkeypatch.setattr("tracer.viewpoint.measures.names", lambda: ["entropy", "silhouette_length", "visible"])
    call("best", scene, "-o", tmp_path / "best", "--random", 3000, "--search", "paper", "-q")
    assert 0 < json.loads((tmp_path / "best" / "best.json").read_text())["stderr"] < 0.1
    said = call("measure", scene, "-o", tmp_path / "all", "--random", 3000, "--level", 0)
    assert "silhouette" not in said  # it needs an image
    with open(tmp_path / "all" / "views.csv", newline="") as file:
        assert all(0 < float(row["entropy_stderr"]) < 0.1 for row in csv.DictReader(file))


SIDES = ["", 'y="1" angle="90"', 'y="1" angle="180"', 'y="1" angle="270"', 'x="1" angle="90"', 'x="1" angle="270"']


@pytest.fixture
def cube(tmp_path):
    """Write a cube of edge 1 of six rectangles."""
    shapes = [
        '<shape type="rectangle"><transform name="to_world"><scale value="0.5"/><translate z="0.5"/>'
        f"{side and f'<rotate {side}/>'}</transform></shape>"
        for side in SIDES
    ]
    path = tmp_path / "cube.xml"
    path.write_text(f'<scene version="3.0.0">{"".join(shapes)}</scene>')
    return path


def test_without_background_one_face_is_the_least_that_a_view_sees(cube, tmp_path):
    few = ["--surfaces", "shape", "--orthographic", "--no-background", "--random", 2000, "-q"]
    call("best", cube, "-o", tmp_path / "out", *few, "--good", "least", "--search", "paper")
    report = json.loads((tmp_path / "out" / "best.json").read_text())
    assert (report["value"], report["stderr"]) == (0, 0)
    assert np.sort(np.abs(report["direction"])) == pytest.approx([0, 0, 1])


@pytest.mark.parametrize(
    ("command", "rays"), [("best", "--random"), ("best", "--side"), ("tour", "--side"), ("cover", "--side")]
)
def test_nothing_in_sight_is_said(command, rays, tmp_path):
    path = tmp_path / "line.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")  # a face without area
    with pytest.raises(TracerError, match="No view sees anything"):
        call(command, path, "-o", tmp_path / "out", rays, 64, "-q")
    assert not (tmp_path / "out").exists()


def test_pictures_lit_by_the_scene(scene, tmp_path):
    few = ["--search", "paper", "-m", "visible", *FEW]
    call("best", scene, "-o", tmp_path / "eye", *few)
    call("best", scene, "-o", tmp_path / "lit", "--spp", 4, *few)
    assert picture(tmp_path / "lit" / "best.png")[0, 0] == pytest.approx(1)  # the sky of the scene
    assert picture(tmp_path / "eye" / "best.png")[0, 0].max() < 0.97
    dark = tmp_path / "dark.xml"
    dark.write_text(SCENE.replace('<emitter type="constant"/>', ""))
    with pytest.raises(TracerError, match="no light in the scene"):
        call("best", dark, "-o", tmp_path / "none", "--spp", 4, *few)
    assert not (tmp_path / "none").exists()


def test_cover_says_what_is_not_seen(scene, tmp_path):
    said = " ".join(call("cover", scene, "-o", tmp_path / "out", "--level", 1, "--enough", 1, "--side", 64).split())
    assert "0 of 13 surfaces, 0.0 % of the visible area, are not shown well. 0, 0.0 % of the whole area" in said
    assert names_in(tmp_path / "out") == ["cameras.xml", "sphere.png", "views.csv", "views.png"]


def test_cover_ends_by_number_and_by_gain(cube, tmp_path):
    """Of a cube's faces, that each view must show from its front, each view shows a sixth."""
    few = ["--surfaces", "shape", "--orthographic", "--quality", 0.999, "--level", 1, "--side", 64]
    said = " ".join(call("cover", cube, "-o", tmp_path / "two", "--views", 2, *few).split())
    assert "4 of 6 surfaces, 66.7 % of the visible area, are not shown well by as many views as were asked for" in said
    assert len(mi.load_file(str(tmp_path / "two" / "cameras.xml")).sensors()) == 2
    said = " ".join(call("cover", cube, "-o", tmp_path / "one", "--gain", 0.2, *few).split())
    assert "5 of 6 surfaces, 83.3 % of the visible area" in said
    assert "no other view would show well another 20 % of it (--gain)" in said
    assert "0 of 6" in call("cover", cube, "-o", tmp_path / "six", *few)


@pytest.mark.slow
def test_a_crystal_is_shown_along_its_rows(tmp_path):
    a = 3.567
    places = [[0, 0, 0], [0, 2, 2], [2, 0, 2], [2, 2, 0], [1, 1, 1], [1, 3, 3], [3, 1, 3], [3, 3, 1]]
    lines = [f"C {x * a / 4} {y * a / 4} {z * a / 4}" for x, y, z in places]
    path = tmp_path / "diamond.xyz"
    path.write_text(f'8\nLattice="{a} 0 0 0 {a} 0 0 0 {a}" pbc="T T T"\n' + "\n".join(lines))
    out = tmp_path / "out"
    crystal = ["--cut", 7, "--atom-radius", 0.77]
    call("best", path, "-o", out, *crystal, "--search", "exhaustive", "--level", 1, "--side", 128, "-q")
    report = json.loads((out / "best.json").read_text())
    assert report["good"] == "least"
    assert np.sort(np.abs(report["direction"])) == pytest.approx([0, 0.5**0.5, 0.5**0.5], abs=0.02)
    assert report["value"] == pytest.approx(3.7, abs=0.1)  # 3.86 of a ball around a bond


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["measure", "none.ply"], "There is no mesh 'none.ply'."),
        (["measure", "none.xml"], "There is no scene file 'none.xml'."),
        (["measure", "none.xyz"], "There is no molecule file 'none.xyz'."),
        (["measure", "picture.png"], "'picture.png' is no scene, mesh or molecule by its name"),
        (["measure", "SCENE", "-m", "beauty"], "Unknown measure 'beauty'"),
        (["best", "SCENE", "-m", "beauty"], "Unknown measure 'beauty'"),
        (["best", "SCENE", "--search", "lucky"], "Unknown search 'lucky'"),
        (["best", "SCENE", "--good", "some"], "the most or the least, not 'some'"),
        (["tour", "SCENE", "-m", "beauty"], "Unknown measure 'beauty'"),
        (["tour", "SCENE", "--film", "tour.avi"], "ends with .webp or .mp4; 'tour.avi' does not"),
        (["map", "SCENE", "--kind", "luck"], "Unknown kind of complexity 'luck'"),
        (["map", "SCENE", "--sensor", "3"], "no camera 3: it has 1"),
        (["map", "SCENE", "--from", "0", "0", "nan"], "three finite numbers"),
        (["map", "SCENE", "--from", "0", "0", "1", "--centre", "0", "0", "1"], "The eye is where it looks at"),
        (["best", "SCENE", "--random", "100", "-m", "silhouette_length"], "need the view as an image"),
        (["cover", "SCENE", "--rule", "luck"], "Unknown rule 'luck'"),
        (["measure", "SCENE", "--surfaces", "atom"], "Unknown kind of surface 'atom'"),
        (["measure", "SCENE", "--cut", "3"], "are for molecules"),
        (["measure", "SCENE", "--distance", "-1"], "must be positive"),
        (["measure", "SCENE", "--distance", "nan"], "must be positive"),
        (["measure", "SCENE", "--centre", "0", "inf", "0"], "three finite numbers"),
        (["measure", "SCENE", "--up", "0", "0", "0"], "must have a direction"),
    ],
)
def test_a_mistake_is_one_sentence_and_writes_nothing(arguments, sentence, scene, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = names_in(tmp_path)
    with pytest.raises(TracerError) as caught:
        call(*(str(scene) if each == "SCENE" else each for each in arguments), "-o", "out")
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)
    assert names_in(tmp_path) == before


def test_results_are_not_overwritten_unasked(scene, tmp_path):
    few = ["-m", "visible", "--level", 0, *FEW]
    call("measure", scene, "-o", tmp_path / "out", *few)
    with pytest.raises(TracerError, match="exists; choose another folder, or --overwrite"):
        call("measure", scene, "-o", tmp_path / "out", *few)
    call("measure", scene, "-o", tmp_path / "out", "--overwrite", *few)


def test_weights_groups_and_light(scene, tmp_path):
    few = ["--search", "paper", "--surfaces", "shape", "-m", "visible", *FEW]
    call("best", scene, "-o", tmp_path / "weight", "--weight", "ball=5", *few)
    assert json.loads((tmp_path / "weight" / "best.json").read_text())["value"] == 6
    call("best", scene, "-o", tmp_path / "group", "--group", "b*", *few)
    assert json.loads((tmp_path / "group" / "best.json").read_text())["value"] == 1
    call("best", scene, "-o", tmp_path / "light", "--by-light", *few)
    assert 0 < json.loads((tmp_path / "light" / "best.json").read_text())["value"] < 2
    with pytest.raises(TracerError, match="Nothing is called 'bal', did you mean 'ball'"):
        call("best", scene, "-o", tmp_path / "none", "--weight", "bal=5", *few)
    assert not (tmp_path / "none").exists()


def test_a_molecule_from_another(scene, tmp_path):
    for name, x in (("near", 0.0), ("far", 9.0)):
        (tmp_path / f"{name}.xyz").write_text(f"2\n\nC {x} 0 0\nO {x} 1.2 0\n")
    call("best", tmp_path / "far.xyz", "--from", tmp_path / "near.xyz", "-o", tmp_path / "out", "-q")
    assert names_in(tmp_path / "out") == ["best.json", "best.png", "camera.xml", "sites.csv"]
    assert json.loads((tmp_path / "out" / "best.json").read_text())["eye"][0] > 1
    for more in (["--side", 64], ["--inside"], ["--search", "paper"]):
        with pytest.raises(TracerError, match=f"leave out {more[0]}"):
            call("best", tmp_path / "far.xyz", "--from", tmp_path / "near.xyz", *more, "-o", tmp_path / "none", "-q")
    with pytest.raises(TracerError, match="is none by its name"):
        call("best", tmp_path / "far.xyz", "--from", scene, "-o", tmp_path / "none", "-q")
    assert not (tmp_path / "none").exists()


def test_molecules_are_shown_as_asked(tmp_path):
    """Two bonds of water are drawn, and count if they are asked to; far places are told in the report."""
    path = tmp_path / "water.xyz"
    path.write_text("3\n\nO 1e7 0 0\nH 10000000.76 0.59 0\nH 9999999.24 0.59 0\n")
    few = ["--search", "paper", "-m", "visible", "--side", 64]
    said = call("best", path, "-o", tmp_path / "drawn", *few)
    assert "2 bonds are drawn; they hide what is behind them and count as background" in said
    report = json.loads((tmp_path / "drawn" / "best.json").read_text())
    assert report["value"] == 3
    assert ["count as background" in remark for remark in report["remarks"]] == [True]
    assert report["origin"] == pytest.approx([1e7, 0.295, 0])
    assert np.abs(report["eye"]).max() < 100
    said = call("best", path, "-o", tmp_path / "counted", "--count-bonds", *few)
    assert "2 bonds are drawn, and count as surfaces" in said
    assert json.loads((tmp_path / "counted" / "best.json").read_text())["value"] == 5
    assert "bonds" not in call("best", path, "-o", tmp_path / "full", "--style", "space-filling", *few)
    pictures = [picture(tmp_path / name / "best.png") for name in ("drawn", "full")]
    filled = [np.mean(np.abs(shown - shown[0, 0]).max(axis=-1) > 0.02) for shown in pictures]
    assert filled[1] > 1.3 * filled[0] > 0
    for more, sentence in (
        (["--style", "sticks"], "Unknown style 'sticks'; choose one of ball-and-stick, space-filling."),
        (["--style", "space-filling", "--count-bonds"], "no bonds to count"),
        (["--model", "2"], "PDB and mmCIF files have models"),
    ):
        with pytest.raises(TracerError, match=sentence):
            call("best", path, *more, "-o", tmp_path / "none", "-q")
    assert not (tmp_path / "none").exists()
