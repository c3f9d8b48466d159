"""Command ``radiosity``: what it writes, and one sentence for a mistake."""

import csv
import re

import meshio
import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

from tracer.cli.app import app
from tracer.errors import TracerError
from tracer.image.colour import LUMINANCE
from tracer.io import exr

SCENE = """<scene version="3.0.0">
    <sensor type="perspective">
        <transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
        <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/></film>
    </sensor>
    <shape type="rectangle" id="floor">MATERIAL</shape>
    <shape type="rectangle" id="lamp">
        <transform name="to_world"><rotate y="1" angle="180"/><translate z="6"/></transform>
        <emitter type="area"><rgb name="radiance" value="9"/></emitter>
    </shape>
    EXTRA
</scene>"""


def scene(folder, material='<bsdf type="diffuse"/>', extra=""):
    path = folder / "scene.xml"
    path.write_text(SCENE.replace("MATERIAL", material).replace("EXTRA", extra))
    return path


def call(*arguments):
    result = CliRunner().invoke(app, ["radiosity", *map(str, arguments)])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.output


@pytest.mark.parametrize(
    "shown", [[], ["--show", "patches"], ["--show", "smooth"], ["--method", "shooting"], ["--spread", "paper_right"]]
)
def test_a_picture_and_what_it_took(tmp_path, shown):
    said = call(scene(tmp_path), "-o", tmp_path / "out.exr", "--spp", 16, "--rays", 64, "--patch", 0.5, *shown)
    assert "patches" in said
    assert "residual" in said
    names, values, _ = exr.read_exr(tmp_path / "out.exr")
    middle = values[8, 12, [names.index(name) for name in "RGB"]]
    # A square of side 2 at distance 6 above its like: its form factor from the middle (Howell B-4) times 9 times 0.5.
    a = 1 / 6
    factor = 4 * a / np.sqrt(1 + a * a) * np.arctan(a / np.sqrt(1 + a * a)) / np.pi
    assert middle == pytest.approx(np.full(3, 9 * 0.5 * factor), rel=0.03)


@pytest.mark.parametrize("method", ["gathering", "shooting"])
def test_the_bias_of_the_rules_of_the_paper_is_told(tmp_path, method):
    few = ["--spp", 1, "--rays", 64, "--patch", 1, "--depth", 0, "--method", method]
    said = call(scene(tmp_path), "-o", tmp_path / "out.exr", "--spread", "paper", *few)
    # Area times cosine is 2 / sqrt(3) of the energy; patches that send little have fewer rays than octants.
    assert re.search(r"carry 115\.\d % of their energy by the paper's rules: the result is biased\.", said)
    assert "biased" not in call(scene(tmp_path), "-o", tmp_path / "right.exr", "--spread", "paper_right", *few)


def test_what_is_done_is_said_before_it_begins(tmp_path, monkeypatch):
    said = []
    monkeypatch.setattr("tracer.cli.progress.Steps.begin", lambda _, text: said.append(text))
    monkeypatch.setattr("tracer.core.backend.activate", lambda: said.append("activated"))
    call(scene(tmp_path), "-o", tmp_path / "out.exr", "--spp", 1, "--rays", 4, "--patch", 1)
    assert said[:3] == ["Starting Mitsuba", "activated", "Opening scene.xml"]


def test_what_is_not_diffuse_is_named_or_refused(tmp_path):
    rough = scene(tmp_path, '<bsdf type="roughplastic"/>')
    few = ["--spp", 1, "--rays", 4, "--patch", 1]
    assert "floor" in call(rough, "-o", tmp_path / "out.png", *few)
    with pytest.raises(TracerError, match="not diffuse: 'floor'; leave out --strict"):
        call(rough, "-o", tmp_path / "strict.png", "--strict", *few)
    assert not (tmp_path / "strict.png").exists()


def test_media_are_named_or_refused(tmp_path):
    medium = '<medium type="homogeneous" name="interior"/>'
    cloudy = scene(tmp_path, extra=f'<shape type="cube" id="cloud">{medium}<bsdf type="diffuse"/></shape>')
    few = ["--spp", 1, "--rays", 4, "--patch", 1]
    assert "Media are left out, as radiosity knows only surfaces: 'cloud'.\n" in call(
        cloudy, "-o", tmp_path / "out.png", *few
    )
    with pytest.raises(TracerError, match=r"leaves out the media of '.*scene.xml': 'cloud'; leave out --strict"):
        call(cloudy, "-o", tmp_path / "strict.png", "--strict", *few)
    assert not (tmp_path / "strict.png").exists()


@pytest.mark.parametrize(
    ("arguments", "extra", "sentence"),
    [
        (["--patch", "0"], "", "is a length above 0"),
        (["--residual", "2"], "", "share between 0 and 1"),
        (["--method", "paper"], "", "not 'paper'; 'paper' is a way to spread rays: "),
        (["--spread", "papr"], "", "spread is one of guided, evenly, randomly, paper, paper_right"),
        (["--sensor", "3"], "", "sensor"),
        (["--patch", "0.01", "--rays", "1048576"], "", "allow longer edges of patches, or fewer rays"),
        ([], '<shape type="linearcurve" id="hair"><string name="filename" value="hair.txt"/></shape>', "none: 'hair'"),
        ([], '<emitter type="point" id="spark"/>', "and the light 'spark' does not"),
    ],
)
def test_a_mistake_is_one_sentence_and_writes_nothing(arguments, extra, sentence, tmp_path):
    (tmp_path / "hair.txt").write_text("0 0 0 0.1\n0 0 1 0.1\n0 1 1 0.1\n")
    with pytest.raises(TracerError, match=sentence) as caught:
        call(scene(tmp_path, extra=extra), "-o", tmp_path / "out.png", *arguments)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out.png").exists()


FEW = ("--spp", 4, "--rays", 64, "--patch", 0.5)


def test_illuminance_by_pixel_and_by_surface(tmp_path):
    files = [tmp_path / name for name in ("lux.png", "lux.exr", "lux.csv")]
    named = [argument for path in files for argument in ("--illuminance", path)]
    said = call(scene(tmp_path), *named, "--range", "0,30", "--efficacy", 2, "--spp", 64, "--rays", 64, "--patch", 0.5)
    assert "uniformity" in said
    assert "lux.csv" in said
    names, values, about = exr.read_exr(files[1])
    assert names == ["Y"]
    assert about["unit"] == "lux"
    assert float(about["efficacy"]) == 2
    a = 1 / 6
    factor = 4 * a / np.sqrt(1 + a * a) * np.arctan(a / np.sqrt(1 + a * a)) / np.pi
    middle = 2 * np.pi * 9 * factor
    assert values[8, 12, 0] == pytest.approx(middle, rel=0.03)
    assert values[0, 0, 0] == 0
    table = list(csv.DictReader(files[2].open()))
    floor = next(row for row in table if row["surface"] == "floor")
    assert float(floor["area"]) == pytest.approx(4)
    assert float(floor["greatest"]) == pytest.approx(middle, rel=0.03)
    assert float(floor["uniformity"]) == pytest.approx(float(floor["least"]) / float(floor["mean"]), rel=1e-3)
    assert files[0].stat().st_size > 0


@pytest.mark.parametrize("method", ["gathering", "shooting"])
def test_patches_and_their_light_are_exported_without_a_picture(tmp_path, method):
    files = [tmp_path / "patches.vtu", tmp_path / "patches.glb"]
    said = call(scene(tmp_path), "--export", files[0], "--export", files[1], "--method", method, *FEW)
    assert "uniformity" not in said
    mesh = meshio.read(files[0])
    columns = {name: column for name, (column,) in mesh.cell_data.items()}
    assert columns["radiosity"] == pytest.approx(columns["emitted"] + columns["albedo"] * columns["irradiance"])
    assert columns["illuminance"] == pytest.approx(683 * columns["irradiance"] @ LUMINANCE)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["patches.glb", "patches.vtu", "scene.xml"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "nothing to write; name a file with -o, --illuminance or --export"),
        (["-o", "a.png", "--illuminance", "a.png"], "'a.png' cannot hold two things"),
        (["-o", "a.png", "--logarithmic"], "--logarithmic is the scale of false colours"),
        (["--illuminance", "a.csv", "--logarithmic"], "--logarithmic is the scale of false colours"),
        (["--illuminance", "a.csv", "--range", "0,500"], "--range is the scale of false colours"),
        (["--illuminance", "a.png", "--range", "500"], "A range is two numbers of lux such as 0,500, not '500'"),
        (["-o", "a.png", "--efficacy", "683"], "--efficacy makes lux of light"),
        (["--illuminance", "a.png", "--efficacy", "0"], "lumens above 0"),
        (["--illuminance", "a.jpg"], "'a.jpg' must end in .png or .exr or .csv"),
        (["--export", "a.vtk"], "'a.vtk' must end in .vtu or .glb"),
    ],
)
def test_wishes_that_cannot_be_met_are_refused_in_one_sentence(tmp_path, monkeypatch, arguments, sentence):
    path = scene(tmp_path)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(TracerError, match=sentence) as caught:
        call(path, *arguments)
    assert "\n" not in str(caught.value)
    assert [found.name for found in tmp_path.iterdir()] == ["scene.xml"]


def model(path):
    """Write a table of brass on a floor of plaster."""
    parts = trimesh.Scene()
    for name, material, metallic, extents, height in (
        ("table", "brass", 1.0, [1, 0.2, 1], 0.5),
        ("floor", "plaster", 0.0, [3, 0.1, 3], 0.0),
    ):
        box = trimesh.creation.box(extents)
        box.apply_translation([0, height, 0])
        look = trimesh.visual.material.PBRMaterial(name=material, metallicFactor=metallic, roughnessFactor=1.0)
        box.visual = trimesh.visual.TextureVisuals(material=look)
        parts.add_geometry(box, node_name=name, geom_name=name)
    parts.export(path)
    return path


def test_a_mesh_alone_is_solved_in_a_neutral_light_and_its_materials_are_named(tmp_path):
    few = ["--spp", 2, "--rays", 32, "--size", 40]
    said = call(model(tmp_path / "model.glb"), "-o", tmp_path / "out.png", "--illuminance", tmp_path / "lux.csv", *few)
    assert "material 'brass' of 'table'" in said
    assert "BSDF" not in said
    rows = {row["surface"]: row for row in csv.DictReader((tmp_path / "lux.csv").open())}
    assert {name: row["material"] for name, row in rows.items() if name != "lamp"} == {
        "table": "brass",
        "floor": "plaster",
    }
    assert float(rows["table"]["mean"]) > 0


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl"])
def test_meshes_of_other_formats(tmp_path, suffix):
    trimesh.creation.icosphere(1).export(tmp_path / f"ball{suffix}")
    few = ["--spp", 1, "--rays", 8, "--size", 24, "--patch", 1]
    call(tmp_path / f"ball{suffix}", "-o", tmp_path / "out.png", *few)
    assert (tmp_path / "out.png").exists()


def test_a_mesh_that_is_not_there_is_one_sentence(tmp_path):
    with pytest.raises(TracerError, match="There is no mesh"):
        call(tmp_path / "none.glb", "-o", tmp_path / "out.png")
