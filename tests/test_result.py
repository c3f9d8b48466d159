"""What a render is written as: every layer under a name of its own, whole or kept elsewhere."""

import json

import mitsuba as mi
import numpy as np
import pytest

import tracer
from conftest import small_scene
from tracer import result as output
from tracer.errors import OutputError, WriteError
from tracer.image.colour import display
from tracer.io import exr
from tracer.result import metadata


@pytest.fixture
def result(cornell):
    return tracer.render(cornell(pixel_format="rgba"), spp=8, seed=3)


def test_exr_holds_all_layers_and_metadata(tmp_path, result):
    path = tmp_path / "out.exr"
    output.write_result(path, result, metadata(result, "abc"))
    names, values, own = exr.read_exr(path)
    stderr = [f"stderr.{c}" for c in "RGBA"]
    single = ("samples", "complexity", "importance", "cost")
    assert sorted(names) == sorted([*"RGBA", *stderr, *(f"{name}.Y" for name in single)])

    def layer(*wanted):
        return values[..., [names.index(name) for name in wanted]]

    assert np.array_equal(layer(*"RGBA"), result.image)
    assert np.array_equal(layer("samples.Y")[..., 0], result.samples.astype(np.float32))
    assert np.array_equal(layer(*stderr), result.stderr)
    for name in single[1:]:
        assert np.array_equal(layer(f"{name}.Y")[..., 0], getattr(result, name))
    assert values.dtype == np.float32
    expected = {"spp": 8, "seed": 3, "criterion": "fused", "objective": "relative", "scene_hash": "abc", "complete": 1}
    assert {name: own[name] for name in expected} == expected
    assert own["seconds"] == pytest.approx(result.seconds, rel=1e-6)
    assert json.loads(own["report"])["settings"]["spp"] == 8
    assert [path.name for path in tmp_path.iterdir()] == ["out.exr"]


def test_a_part_of_a_picture_is_shown_in_its_place(tmp_path, cornell):
    part = tracer.render(cornell(), spp=4, criterion="uniform", crop=(5, 3, 7, 6))
    output.write_result(tmp_path / "part.exr", part, {})
    with exr.opened(tmp_path / "part.exr") as source:
        found = source.spec()
    assert (found.x, found.y, found.width, found.height) == (5, 3, 7, 6)
    assert (found.full_x, found.full_y, found.full_width, found.full_height) == (0, 0, 24, 16)


def test_png_is_what_a_screen_shows(tmp_path, result):
    output.write_result(tmp_path / "out.png", result, {})
    _, values, _ = exr.read_exr(tmp_path / "out.png")
    assert values == pytest.approx(display(result.image), abs=0.6 / 255)


def test_a_picture_is_kept_where_there_is_room(tmp_path, small_disk, result, monkeypatch):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(elsewhere))
    disk = small_disk(8192)
    with pytest.raises(WriteError, match=r"out\.exr'.*The picture is kept as") as raised:
        output.write_result(disk / "out.exr", result, {})
    (kept,) = elsewhere.rglob("out.exr")
    assert f"'{disk / 'out.exr'}'" in str(raised.value)
    assert f"'{kept}'" in str(raised.value)
    names, values, _ = exr.read_exr(kept)
    assert np.array_equal(values[..., [names.index(name) for name in "RGBA"]], result.image)
    assert list(disk.iterdir()) == []


def read_by_mitsuba(path):
    bitmap = mi.Bitmap(str(path))
    fields = bitmap.struct_()
    return [fields[k].name for k in range(len(fields))], np.array(bitmap)


AOVS = {
    "features": "albedo:albedo,normal:sh_normal,depth:depth,idx:shape_index",
    "stderr": "stderr:albedo,stderr.R:depth,samples:depth,importance:depth",
    "depth": "depth:sh_normal,shape:depth",
    "twice": "a:depth,a:depth,aov.a:depth",
    "both": "albedo:albedo,aov.albedo:albedo,stderr.albedo:albedo",
}


@pytest.mark.parametrize("features", [False, True])
@pytest.mark.parametrize("aovs", AOVS.values(), ids=AOVS)
def test_every_channel_has_a_name_of_its_own_whatever_aovs_are_called(tmp_path, aovs, features):
    integrator = {"type": "aov", "aovs": aovs, "image": {"type": "path"}}
    result = tracer.render(small_scene((6, 4), pixel_format="rgba"), integrator=integrator, spp=2, features=features)
    path = tmp_path / "out.exr"
    output.write_result(path, result, {})
    own = exr.own_names(result.channels, exr.layers_of(output.single_channels(result)))
    expected = dict(zip(own, np.moveaxis(result.image, -1, 0), strict=True))
    expected |= {f"stderr.{name}": result.stderr[..., k] for k, name in enumerate(own)}
    expected |= {f"{name}.Y": getattr(result, name) for name in ("samples", "complexity", "importance", "cost")}
    if features:
        seen = result.seen.features
        expected |= {f"albedo.{name}": seen.albedo[..., k] for k, name in enumerate("RGB")}
        expected |= {f"normal.{name}": seen.normal[..., k] for k, name in enumerate("XYZ")}
        expected |= {"depth.Z": seen.depth, "shape.Y": result.seen.shapes}
    assert len(expected) == 2 * len(own) + (12 if features else 4)
    for read in (lambda path: exr.read_exr(path)[:2], read_by_mitsuba):
        names, values = read(path)
        assert sorted(names) == sorted(expected)
        for name, channel in expected.items():
            assert np.array_equal(values[..., names.index(name)], channel.astype(np.float32), equal_nan=True), name


@pytest.mark.parametrize("pixel_format", ["rgba", "luminance", "xyz"])
def test_plain_rgb_is_what_mitsuba_takes_for_a_texture(tmp_path, pixel_format):
    aovs = {"type": "aov", "aovs": "depth:depth", "image": {"type": "path"}}
    scene = small_scene((6, 4), pixel_format=pixel_format)
    result = tracer.render(scene, integrator=aovs, spp=4, seed=3)
    path = tmp_path / "plain.exr"
    output.write_result(path, result, {"spp": 4}, "rgb")
    names, values, own = exr.read_exr(path)
    assert (names, own["spp"]) == (["R", "G", "B"], 4)
    colours = {"rgba": slice(3), "luminance": [0, 0, 0], "xyz": slice(3)}[pixel_format]
    expected = result.image[..., colours]
    if pixel_format == "xyz":  # IEC 61966-2-1
        matrix = [
            [0.4124564, 0.3575761, 0.1804375],
            [0.2126729, 0.7151522, 0.0721750],
            [0.0193339, 0.1191920, 0.9503041],
        ]
        expected = np.linalg.solve(matrix, expected.reshape(-1, 3).T).T.reshape(expected.shape)
    assert values == pytest.approx(expected, rel=1e-3, abs=1e-4)
    assert np.array(mi.Bitmap(str(path))) == pytest.approx(values)
    texture = mi.load_dict({"type": "bitmap", "filename": str(path), "raw": True, "filter_type": "nearest"})
    assert np.array(mi.traverse(texture)["data"]) == pytest.approx(values)
    mi.load_dict({"type": "envmap", "filename": str(path)})


def test_a_result_saves_itself_with_all_layers_and_what_made_it(tmp_path, result):
    result.save(tmp_path / "out.exr")
    names, values, own = exr.read_exr(tmp_path / "out.exr")
    assert np.array_equal(values[..., [names.index(name) for name in "RGBA"]], result.image)
    assert {"samples.Y", "complexity.Y", "stderr.R"} < set(names)
    assert (own["spp"], own["seed"], own["version"]) == (8, 3, tracer.__version__)
    assert "scene_hash" not in own
    result.save(str(tmp_path / "plain.exr"), layers="rgb")
    assert exr.read_exr(tmp_path / "plain.exr")[0] == ["R", "G", "B"]
    result.save(tmp_path / "out.png")
    assert exr.read_exr(tmp_path / "out.png")[1] == pytest.approx(display(result.image), abs=0.6 / 255)


@pytest.mark.parametrize(
    ("name", "keywords", "message"),
    [
        ("out.exr", {}, r"'.*out\.exr' exists; choose another name, or overwrite=True to replace it\."),
        ("out.jpg", {}, r"must end in \.exr or \.png"),
        ("no/out.exr", {}, "There is no folder"),
        ("new.exr", {"layers": "some"}, r"layers: write all or rgb \(was 'some'\)"),
    ],
)
def test_a_result_is_not_saved_where_it_must_not(tmp_path, result, name, keywords, message):
    (tmp_path / "out.exr").write_text("mine")
    with pytest.raises(OutputError, match=message):
        result.save(tmp_path / name, **keywords)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("out.exr", "mine")]
    result.save(tmp_path / "out.exr", overwrite=True)
    assert exr.read_metadata(tmp_path / "out.exr")["complete"] == 1


def test_a_result_and_its_report_say_what_a_person_wants_to_know(cornell):
    result = tracer.render(cornell(), spp=4)
    height, width = result.samples.shape
    assert repr(result) == f"Result({width} x {height}, 4 samples per pixel, {result.seconds:.1f} s)"
    text = str(result.report)
    assert text.startswith("4 samples per pixel in 1 round, after which pixels had 4; ended by its budget of samples.")
    assert all(note in text for note in result.report.notes)
