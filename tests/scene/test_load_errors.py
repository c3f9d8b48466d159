"""What Mitsuba says of a scene, and what we add: what is meant, or to do, of the same kind of plugin."""

import mitsuba as mi
import pytest

import tracer
from tracer.errors import SceneError
from tracer.scene.load import load
from tracer.scene.load_errors import advice, kind_of, plugin_names

BITMAP = '<bsdf type="diffuse"><{} name="reflectance" value="{}"/></bsdf>'


@pytest.mark.parametrize("version", ["0.6.0", "3.0.0"])
@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        (
            '<integrator type="bdpt"/>',
            "'bdpt' is no integrator plugin of Mitsuba 3; use 'path', or 'volpath' where there are media.",
        ),
        (
            '<bsdf type="phong"/>',
            "'phong' is no bsdf plugin of Mitsuba 3; use 'roughplastic', or 'roughconductor' for a metal.",
        ),
        (
            '<integrator type="path"><boolean name="strictNormals" value="true"/></integrator>',
            "s' is of earlier versions of Mitsuba; leave it out.",
        ),
        (
            BITMAP.format("srgb", "#ff8000"),
            "<srgb> is of earlier versions of Mitsuba; use <rgb> with three linear numbers, each of the encoded v "
            "being ((v + 0.055) / 1.055)^2.4.",
        ),
        (BITMAP.format("rgb", "#ff8000"), 'three numbers, linear in light; #ff8000 of a screen is "1, 0.2159, 0".'),
        ('<bsdf type="srgb"/>', "'srgb' is a plugin of kind texture, not bsdf."),
        ('<shape type="stl"/>', "so convert it to one of these."),
        ('<shape type="hair"/>', "use 'bsplinecurve' or 'linearcurve'."),
        ('<subsurface type="dipole"/>', "use a medium in the shape, and the integrator 'volpath'."),
        ('<medium type="homogeneous"><string name="material" value="milk"/></medium>', "'sigma_t' and 'albedo' of it."),
        ('<bsdf type="difuse"/>', "Did you mean 'diffuse'?"),
        ('<sensor type="perspective"><sampler type="owen_sobl"/></sensor>', "Did you mean 'owen_sobol'?"),
        ('<integrator type="radiosty"/>', "Did you mean 'radiosity'?"),
        # Near are only plugins of another kind: the integrators depth, path and radiosity, and a bsdf, plastic.
        ('<bsdf type="dept"/>', 'Plugin "dept" not found.'),
        ('<bsdf type="pathh"/>', 'Plugin "pathh" not found.'),
        ('<shape type="radiosty"/>', 'Plugin "radiosty" not found.'),
        ('<integrator type="plastik"/>', 'Plugin "plastik" not found.'),
    ],
)
def test_a_scene_of_another_version_is_told_what_to_do(scene_file, body, sentence, version):
    path = scene_file(body)
    path.write_text(path.read_text().replace("3.0.0", version))
    with pytest.raises(SceneError) as caught:
        load(path)
    assert str(caught.value).startswith(f"'{path}' does not load: ")
    assert str(caught.value).endswith(sentence)
    assert "\n" not in str(caught.value)


def test_all_parameters_that_are_unknown_are_spoken_of(scene_file):
    film = (
        '<film type="hdrfilm"><boolean name="attachLog" value="true"/><string name="pixel_fromat" value="rgb"/></film>'
    )
    body = f'<sensor type="perspective">{film}</sensor>'
    with pytest.raises(
        SceneError, match=r"'attachLog' is of earlier .*; leave it out\. Did you mean 'pixel_format'\?$"
    ):
        load(scene_file(body))


@pytest.mark.parametrize(
    ("integrator", "message"),
    [
        ("bdpt", "'bdpt' is no integrator plugin of Mitsuba 3; use 'path'"),
        ("dept", r"Did you mean 'depth'\?"),
        ("difuse", 'Plugin "difuse" not found.$'),
        ({"type": "path", "strict_normals": True}, "'strict_normals' is of earlier versions of Mitsuba; leave it out"),
    ],
)
def test_an_integrator_from_python(scene_file, integrator, message):
    with pytest.raises(SceneError, match=message):
        tracer.render(scene_file('<emitter type="constant"/><sensor type="perspective"/>'), integrator=integrator)


@pytest.mark.parametrize(
    ("plugin", "message"),
    [("dept", r"Did you mean the integrator 'depth'\?$"), ("phong", "'phong' is no plugin of Mitsuba 3; use 'rough")],
)
def test_a_dictionary_does_not_say_the_kind_so_the_hint_does(plugin, message):
    with pytest.raises(SceneError, match=message):
        load({"type": "scene", "part": {"type": plugin}})


def test_kinds_are_as_scenes_call_them():
    expected = {
        "path": "integrator",
        "radiosity": "integrator",
        "prb": "integrator",
        "owen_sobol": "sampler",
        "hg": "phase",
        "box": "rfilter",
        "srgb": "texture",
        "diffuse": "bsdf",
    }
    assert {name: kind_of(name) for name in expected} == expected
    assert {name: plugin_names()[name] for name in expected} == expected


def test_a_plugin_that_fails_by_itself_gets_no_advice():
    said = 'failed to instantiate {} plugin of type "hair": [Hair] No.'
    assert advice(said.format("bsdf")) == []
    assert advice(said.format("unknown")) == []
    assert advice(said.format("shape")) != []
    assert advice("nothing that is known") == []


def test_a_plugin_of_a_wrong_kind_is_named_by_mitsuba_alone(scene_file):
    with pytest.raises(SceneError, match=r'is of type "integrator".* expected type "bsdf"\.$'):
        load(scene_file('<bsdf type="path"/>'))
    assert mi.variant().startswith("llvm")
