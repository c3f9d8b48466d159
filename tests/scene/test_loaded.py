"""A scene that is loaded once."""

import pytest

from tracer.errors import SceneError
from tracer.scene.fingerprint import fingerprint
from tracer.scene.loaded import load_scene

LAMP = '<shape type="sphere"><emitter type="area"><rgb name="radiance" value="$light"/></emitter></shape>'


def test_it_is_what_the_file_was_when_it_was_loaded(scene_file):
    path = scene_file(LAMP)
    define = {"light": "2"}
    loaded = load_scene(path, define)
    assert (loaded.path, loaded.define, loaded.scene_hash) == (path, define, fingerprint(path, define))
    assert loaded.scene.class_name() == "Scene"
    assert load_scene(path, {"light": "3"}).scene_hash != loaded.scene_hash
    scene_file(LAMP.replace("sphere", "cube"))
    assert fingerprint(path, define) != loaded.scene_hash


def test_what_is_no_scene_is_refused(tmp_path):
    path = tmp_path / "mesh.xml"
    path.write_text('<shape version="3.0.0" type="sphere"/>')
    with pytest.raises(SceneError, match="holds a Sphere, not a scene; wrap it in <scene>"):
        load_scene(path)
