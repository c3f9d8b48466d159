"""Scenes that load, scenes that do not, and what identifies their content."""

import mitsuba as mi
import numpy as np
import pytest

from conftest import LIT, SENSOR
from tracer.errors import SceneError, SettingsError
from tracer.scene.fingerprint import fingerprint
from tracer.scene.load import load
from tracer.scene.load_errors import render_error
from tracer.scene.view import open_scene


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ('<bsdf type="difuse"/>', "Did you mean 'diffuse'"),
        ('<integrator type="adaptve"/>', "Did you mean 'adaptive'"),
        ('<integrator type="path"><integer name="max_dept" value="5"/></integrator>', "Did you mean 'max_depth'"),
        ('<bsdf type="diffuse"><float name="reflectanse" value="1"/></bsdf>', "Did you mean 'reflectance'"),
        ("<shape>", "tags mismatch"),
        ('<shape type="ply"><string name="filename" value="none.ply"/></shape>', "none.ply"),
        ('<integrator type="path"><string name="max_depth" value="deep"/></integrator>', "max_depth"),
        ('<integrator type="adaptive"><string name="criterion" value="fuse"/></integrator>', "did you mean 'fused'"),
        ('<integrator type="adaptive"><integer name="threshold" value="1"/></integrator>', "threshold"),
        ('<integrator type="adaptive"><integer name="spp" value="0"/></integrator>', "greater than or equal to 1"),
        ('<integrator type="adaptive"><integrator type="ptracer"/></integrator>', "cannot be sampled pixel by pixel"),
        ('<integrator type="path"/>', "has no sensor"),
        ('<texture type="bitmap" id="t"/>', "has a 'bitmap' without a picture"),
        (LIT.replace('"height" value="8"', '"height" value="-0"'), "has a film without pixels"),
    ],
)
def test_a_scene_that_cannot_be_rendered_is_one_sentence(scene_file, body, message):
    path = scene_file(body)
    with pytest.raises(SceneError) as caught, open_scene(path):
        pass
    text = str(caught.value)
    assert message in text
    assert str(path) in text
    assert "\n" not in text
    assert "Traceback" not in text


def test_missing_files_folders_and_strangers(tmp_path):
    for source, message in ((tmp_path / "no.xml", "There is no scene file"), (tmp_path, "is a folder"), (7, "not int")):
        with pytest.raises(SceneError, match=message):
            load(source)


def test_spectra_beside_the_scene_are_found_and_count(scene_file, tmp_path):
    path = scene_file('<emitter type="constant"><spectrum name="radiance" filename="light.spd"/></emitter>')
    (tmp_path / "light.spd").write_text("400 1\n700 2\n")
    load(path)
    before = fingerprint(path)
    (tmp_path / "light.spd").write_text("400 1\n700 3\n")
    assert fingerprint(path) != before


def test_text_that_is_not_utf8(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_bytes(b'<scene version="3.0.0"><bsdf type="diffuse"><string name="a\xa3" value="\xa3"/></bsdf></scene>')
    with pytest.raises(SceneError, match="not UTF-8"):
        fingerprint(path)


def test_faces_between_vertices_that_do_not_exist(scene_file, tmp_path):
    header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    mesh = tmp_path / "mesh.ply"
    path = scene_file(LIT + '<shape type="ply" id="roof"><string name="filename" value="mesh.ply"/></shape>')
    mesh.write_text(header + "3 0 1 2\n")
    load(path)
    mesh.write_text(header + "3 0 1 7\n")
    with pytest.raises(SceneError, match="with faces that use vertex 7, counted from 0, and only 3"):
        load(path)


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        ("[BlackBodySpectrum] Not implemented.", "a.xml cannot be rendered: [BlackBodySpectrum] Not implemented."),
        ("[shape.cpp:12] No\n  such!", "a.xml cannot be rendered: [shape.cpp:12] No such."),
        ("jit_var_gather(): nothing", "a.xml cannot be rendered: jit_var_gather(): nothing."),
        ("mine", None),
        ("[1] is mine", None),
    ],
)
def test_what_mitsuba_says_only_when_it_renders_is_one_sentence(said, expected):
    error = render_error("a.xml", RuntimeError(said))
    assert (str(error) if error else None) == expected


def test_errors_of_others_pass_while_a_scene_is_open(scene_file):
    with pytest.raises(RuntimeError, match="mine"), open_scene(scene_file(LIT)):
        raise RuntimeError("mine")


def test_a_picture_that_no_memory_holds(scene_file):
    path = scene_file(LIT)
    for keywords in ({"size": 2**20}, {"size": 2**21}, {"size": (10**12, 1)}):
        with pytest.raises(SettingsError, match="pixel"), open_scene(path, **keywords):
            pass
    with open_scene(path, size=2**20, crop=(5, 5, 4, 4)) as view:
        assert view.size == (4, 4)


def test_a_file_that_holds_no_scene(tmp_path):
    path = tmp_path / "bsdf.xml"
    path.write_text('<bsdf version="3.0.0" type="diffuse"/>')
    with pytest.raises(SceneError, match="not a scene"), open_scene(path):
        pass


def test_sensor_and_integrator_are_checked(scene_file):
    path = scene_file(LIT)
    with pytest.raises(SettingsError, match="There is no sensor 3"), open_scene(path, sensor=3):
        pass
    with pytest.raises(SettingsError, match="cannot be sampled"), open_scene(path, integrator="ptracer"):
        pass
    with pytest.raises(SceneError, match="Did you mean 'volpath'"), open_scene(path, integrator="volpat"):
        pass
    with open_scene(path, integrator={"type": "direct"}) as view:
        assert view.integrator.class_name() == "DirectIntegrator"


def test_a_sampler_can_take_the_place_of_the_scenes(scene_file):
    scene = load(scene_file(LIT), sampler="multijitter")
    assert scene.sensors()[0].sampler().class_name() == "MultijitterSampler"


def test_a_film_is_resized_and_restored(cornell):
    scene = mi.load_dict(cornell(size=(24, 16)))
    for size, expected in ((12, (8, 12)), ((30, 40), (40, 30)), (None, (16, 24))):
        with open_scene(scene, size=size) as view:
            assert view.size == expected
            assert np.array(view.integrator.render(view.scene, spp=1)).shape == (*expected, 3)
    assert tuple(scene.sensors()[0].film().size()) == (24, 16)
    with pytest.raises(SettingsError, match="at least 1 pixel"), open_scene(scene, size=0):
        pass


def test_a_crop_window_is_scaled_with_the_film(cornell):
    film = {"crop_width": 3, "crop_height": 3, "crop_offset_x": 3, "crop_offset_y": 3}
    scene = mi.load_dict(cornell(size=(6, 6), **film))
    with open_scene(scene, size=3) as view:
        assert view.size in ((1, 1), (2, 2))
    with open_scene(scene) as view:
        assert view.size == (3, 3)


def test_a_replaced_sampler_keeps_only_its_sample_count(cornell):
    scene = cornell()
    scene["sensor"]["sampler"] = {"type": "stratified", "sample_count": 16, "jitter": False}
    assert load(scene, sampler="independent").sensors()[0].sampler().sample_count() == 16


def test_fingerprint_follows_every_file_of_a_scene(tmp_path, scene_file):
    mesh = tmp_path / "mesh.ply"
    included = tmp_path / "part.xml"
    mi.load_dict({"type": "cube"}).write_ply(str(mesh))
    included.write_text('<scene version="3.0.0"><bsdf type="diffuse" id="white"/></scene>')
    body = f'{SENSOR}<include filename="part.xml"/><shape type="ply"><string name="filename" value="mesh.ply"/></shape>'
    path = scene_file(body)
    prints = [fingerprint(path), fingerprint(path)]
    assert prints[0] == prints[1]
    mesh.write_bytes(mesh.read_bytes() + b" ")
    prints.append(fingerprint(path))
    included.write_text(included.read_text() + " ")
    prints.append(fingerprint(path))
    scene_file(body + LIT)
    prints.append(fingerprint(path))
    assert len(set(prints)) == 4


def test_fingerprint_of_a_dictionary(cornell):
    assert fingerprint(cornell()) == fingerprint(cornell())
    assert fingerprint(cornell()) != fingerprint(cornell(size=(9, 9)))


def test_a_sampler_cannot_take_the_place_of_none(scene_file):
    bare = LIT.replace('<sampler type="independent"/>', "")
    with pytest.raises(SceneError, match="without a sampler"):
        load(scene_file(bare), sampler="multijitter")
    assert load(scene_file(bare)).sensors()[0].sampler() is not None


def test_text_that_is_too_long_for_a_name_is_no_file(scene_file):
    names = ",".join(f"name_{number}:depth" for number in range(60))
    path = scene_file(
        LIT.replace(
            '<integrator type="path"/>', f'<integrator type="aov"><string name="aovs" value="{names}"/></integrator>'
        )
    )
    assert len(names) > 255
    assert fingerprint(path) == fingerprint(path)
    assert load(path).class_name() == "Scene"


def test_of_several_errors_the_first_is_told(scene_file):
    meshes = "".join(f'<shape type="ply"><string name="filename" value="{name}.ply"/></shape>' for name in "abcdefgh")
    file = scene_file(SENSOR + meshes)
    for _ in range(20):
        with pytest.raises(SceneError, match=r"a\.ply"):
            load(file)
