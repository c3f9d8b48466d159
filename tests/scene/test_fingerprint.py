"""A scene is known by its content, whatever way it is given: what differs within arrays or in the last digit counts."""

import mitsuba as mi
import numpy as np
import pytest

import tracer
from tracer.errors import CheckpointError
from tracer.scene.fingerprint import content, digest, fingerprint

LARGE = 24
"""Texels a side: what prints of such an array leaves out its middle."""


def texels(value):
    pixels = np.full((LARGE, LARGE, 3), 0.5, np.float32)
    pixels[LARGE // 2, LARGE // 2] = value
    return pixels


def triangle(height):
    mesh = mi.Mesh("triangle", 3, 1)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = mi.Float([-1, -1, height, 1, -1, height, 0, 1, height])
    parameters["faces"] = mi.UInt32([0, 1, 2])
    parameters.update()
    return mesh


def lit(**entries):
    sensor = {"type": "perspective", "film": {"type": "hdrfilm", "width": 6, "height": 4}}
    return {"type": "scene", "integrator": {"type": "path"}, "sensor": sensor, "sky": {"type": "constant"}, **entries}


def sphere(**entries):
    return lit(ball={"type": "sphere", **entries})


def diffuse(reflectance):
    return {"type": "diffuse", "reflectance": reflectance}


def textured(**entries):
    return sphere(bsdf=diffuse({"type": "bitmap", "raw": True, **entries}))


def filled(value):
    grid = mi.VolumeGrid(texels(value))
    return sphere(interior={"type": "heterogeneous", "albedo": {"type": "gridvolume", "grid": grid}})


def raised(value):
    return sphere(to_world=mi.ScalarTransform4f().translate([0, 0, value]))


def moved(value):
    scene = mi.load_dict(lit(box={"type": "cube"}))
    parameters = mi.traverse(scene)
    parameters["box.vertex_positions"] = parameters["box.vertex_positions"] * value
    parameters.update()
    return scene


GIVEN = {
    "bitmap": lambda value: textured(bitmap=mi.Bitmap(texels(value))),
    "tensor": lambda value: textured(data=mi.TensorXf(texels(value))),
    "object": lambda value: sphere(bsdf=mi.load_dict(diffuse({"type": "rgb", "value": value}))),
    "mesh": lambda value: lit(mesh=triangle(value)),
    "volume": filled,
    "last digit of a number": lambda value: sphere(radius=1.0 + value * 1e-9),
    "last digit of a transform": lambda value: raised(1.0 + value * 1e-6),
    "loaded scene": lambda value: mi.load_dict(textured(bitmap=mi.Bitmap(texels(value)))),
    "loaded scene, last digit": lambda value: mi.load_dict(raised(1.0 + value * 1e-6)),
    "loaded and changed scene": moved,
}


@pytest.mark.parametrize("way", GIVEN)
def test_what_a_scene_holds_counts(way):
    first, same, other = (fingerprint(GIVEN[way](value)) for value in (0.25, 0.25, 0.75))
    assert first == same
    assert first != other


@pytest.mark.parametrize("way", ["bitmap", "loaded scene"])
def test_a_checkpoint_of_another_scene_is_refused(way, tmp_path):
    path = tmp_path / "kept.ckpt"
    tracer.render(GIVEN[way](0.1), spp=4, checkpoint=path)
    with pytest.raises(CheckpointError, match="another scene"):
        tracer.render(GIVEN[way](0.9), spp=8, checkpoint=path, resume=True)
    tracer.render(GIVEN[way](0.1), spp=8, checkpoint=path, resume=True)


def test_where_an_object_lies_in_memory_does_not_count():
    class Stranger:
        pass

    assert digest(*content(Stranger())) == digest(*content(Stranger()))


def test_pieces_do_not_run_into_each_other():
    assert digest(b"ab", b"c") != digest(b"a", b"bc")
