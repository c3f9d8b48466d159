"""Scene files are opened as ``mi.load_file`` opens them, feature by feature: both make the same picture."""

from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

import tracer
from tracer.scene.fingerprint import fingerprint
from tracer.scene.load import load

TRIANGLE = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n"
SENSOR = """<sensor type="perspective"><transform name="{to_world}"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/>
</transform><film type="hdrfilm"><integer name="width" value="9"/><integer name="height" value="7"/>
<rfilter type="box"/></film><sampler type="independent"/></sensor>"""
WHITE = '<emitter type="constant"/>'


def scene_text(body, version="3.0.0"):
    to_world = "toWorld" if version.startswith("0") else "to_world"
    return f'<scene version="{version}"><integrator type="path"/>{SENSOR.format(to_world=to_world)}{body}</scene>'


@pytest.fixture
def project(tmp_path):
    """Write files by their names relative to a folder, and return the path of scene.xml in its folder shots."""

    def write(body, version="3.0.0", **files):
        (tmp_path / "shots").mkdir(exist_ok=True)
        for name, text in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        scene = tmp_path / "shots" / "scene.xml"
        scene.write_text(scene_text(body, version))
        return scene

    return write


def same_as_mitsuba(path, sensor=0, **define):
    """Assert that the scene opened by us and by Mitsuba gives one picture, and return it."""
    theirs = mi.load_file(str(path), **define)
    ours = load(path, define=define)
    pictures = [np.array(mi.render(scene, spp=4, seed=1, sensor=sensor)) for scene in (ours, theirs)]
    assert np.array_equal(*pictures)
    return pictures[0]


SHAPE = '<shape type="obj"><string name="filename" value="triangle.obj"/></shape>'


def test_a_folder_that_path_names(project, monkeypatch, tmp_path):
    files = {"common/triangle.obj": TRIANGLE}
    path = project(f'<path value="../common"/>{WHITE}{SHAPE}', **files)
    seen = same_as_mitsuba(path)
    assert seen.min() < 0.9  # the triangle is there
    monkeypatch.chdir(tmp_path)
    assert np.array_equal(same_as_mitsuba(Path("shots/scene.xml")), seen)


def test_path_counts_before_the_folder_of_the_scene_and_the_last_path_first(project):
    small = TRIANGLE.replace("1", "0.1", 1)
    folders = '<path value="../common"/><path value="../newer"/>'
    files = {"common/triangle.obj": small, "shots/triangle.obj": small, "newer/triangle.obj": TRIANGLE}
    path = project(f"{folders}{WHITE}{SHAPE}", **files)
    same_as_mitsuba(path)
    before = fingerprint(path)
    (path.parent.parent / "common" / "triangle.obj").write_text(TRIANGLE + "\n")
    assert fingerprint(path) == before  # not the file that is read
    (path.parent.parent / "newer" / "triangle.obj").write_text(TRIANGLE + "\n")
    assert fingerprint(path) != before


def test_a_folder_that_path_names_is_for_this_scene_alone(project):
    before = [str(folder) for folder in mi.file_resolver()]
    path = project(f'<path value="../common"/>{WHITE}{SHAPE}', **{"common/triangle.obj": TRIANGLE})
    load(path)
    fingerprint(path)
    assert [str(folder) for folder in mi.file_resolver()] == before


def test_resources_of_a_dictionary(project, tmp_path):
    project("", **{"common/triangle.obj": TRIANGLE})
    scene = {
        "type": "scene",
        "folder": {"type": "resources", "path": str(tmp_path / "common")},
        "light": {"type": "constant"},
    }
    scene["shape"] = {"type": "obj", "filename": "triangle.obj"}
    assert len(load(scene).shapes()) == 1
    before = fingerprint(scene)
    (tmp_path / "common" / "triangle.obj").write_text(TRIANGLE.replace("4", "5") + "\n")
    assert fingerprint(scene) != before


def test_included_files(project):
    part = f'<scene version="3.0.0">{SHAPE}<include filename="deep/lights.xml"/></scene>'
    lights = '<scene version="3.0.0"><emitter type="constant"/></scene>'
    files = {"shots/part.xml": part, "shots/deep/lights.xml": lights, "shots/triangle.obj": TRIANGLE}
    same_as_mitsuba(project('<include filename="part.xml"/>', **files))


def test_a_path_in_an_included_file(project):
    part = '<scene version="3.0.0"><path value="../common"/><include filename="lights.xml"/></scene>'
    files = {"shots/part.xml": part, "common/lights.xml": f'<scene version="3.0.0">{WHITE}</scene>'}
    files["shots/triangle.obj"] = TRIANGLE
    same_as_mitsuba(project(f'<include filename="part.xml"/>{SHAPE}', **files))


def test_defaults_and_parameters(project):
    light = '<emitter type="constant"><rgb name="radiance" value="$level"/></emitter>'
    path = project(f'<default name="level" value="0.5"/>{light}')
    assert np.allclose(same_as_mitsuba(path), 0.5)
    assert np.allclose(same_as_mitsuba(path, level="0.25"), 0.25)
    assert fingerprint(path, {"level": "0.25"}) != fingerprint(path)


def test_aliases_and_references(project):
    black = '<bsdf type="diffuse" id="black"><rgb name="reflectance" value="0.1"/></bsdf><alias id="black" as="dark"/>'
    path = project(f'{WHITE}{black}<shape type="sphere"><ref id="dark"/></shape>')
    assert same_as_mitsuba(path).min() < 0.5


@pytest.mark.parametrize("folder", ["shots", "common"])
def test_spectra_of_files(project, folder):
    light = '<emitter type="constant"><spectrum name="radiance" filename="light.spd"/></emitter>'
    path = project(f'<path value="../{folder}"/>{light}', **{f"{folder}/light.spd": "400 1\n550 3\n700 2\n"})
    same_as_mitsuba(path)


def plastic(name):
    return f'<bsdf type="roughplastic"><float name="{name}" value="1.4"/></bsdf>'


@pytest.mark.parametrize(
    ("version", "bsdf"),
    [
        ("0.6.0", '<bsdf type="diffuse"><rgb name="reflectance" value="0.2"/></bsdf>'),
        ("0.6.0", plastic("intIOR")),
        ("2.0.0", plastic("int_ior")),
        ("2.1.0", '<bsdf type="twosided"><bsdf type="diffuse"/></bsdf>'),
        ("3.5.0", '<bsdf type="principled"/>'),
    ],
)
def test_older_versions_are_upgraded(project, version, bsdf):
    same_as_mitsuba(project(f'{WHITE}<shape type="sphere">{bsdf}</shape>', version))


def test_several_sensors(project):
    other = SENSOR.format(to_world="to_world").replace("0,0,4", "0,3,4")
    path = project(f'{WHITE}<shape type="cube"/>{other}')
    assert not np.array_equal(same_as_mitsuba(path, sensor=0), same_as_mitsuba(path, sensor=1))


def test_a_scene_that_names_a_folder_renders_from_anywhere(project, tmp_path, monkeypatch):
    """The mean of this picture is 0.83: of a white sky, a triangle that reflects half of it hides a third."""
    path = project(f'<path value="../common"/>{WHITE}{SHAPE}', **{"common/triangle.obj": TRIANGLE})
    path.write_text(path.read_text().replace('"9"', '"32"').replace('"7"', '"32"'))
    monkeypatch.chdir(tmp_path)
    assert tracer.render("shots/scene.xml", spp=16).image.mean() == pytest.approx(0.8328, abs=0.002)
