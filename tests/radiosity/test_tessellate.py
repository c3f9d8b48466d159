"""Spheres, disks and cylinders as meshes: rays hit them in the same places, on the same sides."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.errors import SceneError
from tracer.radiosity.meshing import cut
from tracer.radiosity.tessellate import tessellated

T = mi.ScalarTransform4f
SCENE = {
    "type": "scene",
    "sky": {"type": "constant"},
    "ball": {"type": "sphere", "center": [1, 2, 3], "radius": 0.7, "flip_normals": True},
    "plate": {
        "type": "disk",
        "to_world": T().translate([-3, 0, 0]).rotate([0.6, 0.8, 0], 40).scale(1.3),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [1.0, 2.0, 3.0]}},
    },
    "rod": {"type": "cylinder", "p0": [0, 0, 0], "p1": [1, 1, 1], "radius": 0.2},
}


@pytest.fixture(scope="module")
def scenes():
    scene = mi.load_dict(SCENE)
    return scene, tessellated(scene, 0.05)


def test_rays_hit_the_same(scenes):
    generator = np.random.default_rng(0)
    origin, toward = generator.uniform(-5, 5, (100_000, 3)), generator.normal(size=(100_000, 3))
    ray = mi.Ray3f(mi.Point3f(*origin.T.astype(np.float32)), dr.normalize(mi.Vector3f(*toward.T.astype(np.float32))))
    a, b = (scene.ray_intersect(ray) for scene in scenes)
    hits = a.is_valid().numpy(), b.is_valid().numpy()
    assert (hits[0] != hits[1]).mean() < 2e-4
    both = hits[0] & hits[1]
    distance = np.abs(np.array(a.p) - np.array(b.p))[:, both].max(axis=0)
    assert np.quantile(distance, 0.99) < 0.01
    assert ((np.array(a.wi)[2, both] > 0) == (np.array(b.wi)[2, both] > 0)).mean() > 0.999
    apart = np.abs(np.array(a.uv) - np.array(b.uv))[:, both]
    assert np.quantile(apart, 0.99) < 0.01


def test_meshes_lie_on_the_surface_and_have_its_light(scenes):
    scene, meshes = scenes
    for shape, mesh in zip(scene.shapes(), meshes.shapes(), strict=True):
        assert mesh.is_mesh()
        area = float(shape.surface_area()[0])
        assert 0.98 * area < float(mesh.surface_area()[0]) < area
    patches = cut(scene, 0.2)
    lit = patches.emitted.max(axis=1) > 0
    assert patches.emitted[lit] == pytest.approx(np.tile(np.pi * np.array([1.0, 2, 3]), (lit.sum(), 1)), rel=1e-5)
    assert patches.areas[lit].sum() == pytest.approx(np.pi * 1.3**2, rel=0.02)


def test_a_scene_of_meshes_is_left_alone():
    scene = mi.load_dict(mi.cornell_box())
    assert tessellated(scene, 0.1) is scene


def test_the_scene_keeps_its_names():
    scene = mi.load_dict({**SCENE, "floor": {"type": "rectangle"}, "box": {"type": "cube"}})
    before = [shape.id() for shape in scene.shapes()]
    keys = set(mi.traverse(scene).keys())
    cut(scene, 0.5)
    assert [shape.id() for shape in scene.shapes()] == before
    assert set(mi.traverse(scene).keys()) == keys


def test_a_texture_that_shines_is_averaged_by_area():
    rows = np.zeros((16, 4, 3), np.float32)
    rows[0] = 100
    texture = {"type": "bitmap", "bitmap": mi.Bitmap(rows), "raw": True, "filter_type": "nearest"}
    ball = {"type": "sphere", "emitter": {"type": "area", "radiance": texture}}
    patches = cut(mi.load_dict({"type": "scene", "ball": ball}), 0.2)
    # The first of 16 rows is (1 - cos(pi / 16)) / 2 of the sphere.
    share = (1 - np.cos(np.pi / 16)) / 2
    assert patches.emitted.max() == pytest.approx(np.pi * 100 * share, rel=0.1)


@pytest.mark.parametrize(
    "shape", [{"type": "sphere", "radius": 0.0}, {"type": "disk", "to_world": T().scale([0, 1, 1])}]
)
def test_a_shape_without_extent_is_a_sentence(shape):
    with pytest.raises((SceneError, RuntimeError), match="no extent"):
        cut(mi.load_dict({"type": "scene", "sky": {"type": "constant"}, "shape": shape}))
