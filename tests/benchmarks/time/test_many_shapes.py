"""The made scene has as many shapes as asked for, each with a BSDF of its own, and is the same whenever it is made."""

import mitsuba as mi

from benchmarks.time.many_shapes import write_scene


def test_every_shape_has_a_bsdf_of_its_own(tmp_path):
    write_scene(tmp_path / "scene.xml", 30)
    scene = mi.load_file(str(tmp_path / "scene.xml"), optimize=False)
    bsdfs = {id(shape.bsdf()) for shape in scene.shapes() if shape.bsdf() is not None}
    assert len(scene.shapes()) == 32  # with a floor and a lamp
    assert len(bsdfs) >= 31
    write_scene(tmp_path / "again.xml", 30)
    assert (tmp_path / "again.xml").read_text() == (tmp_path / "scene.xml").read_text()
