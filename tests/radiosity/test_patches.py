"""Patches: their cells, what they are made of, and that rays find them."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.errors import SceneError
from tracer.radiosity.gathering import solve
from tracer.radiosity.guide import Guidance
from tracer.radiosity.hemisphere import NOTHING
from tracer.radiosity.meshing import cell_centres, cut
from tracer.radiosity.patches import cell_of

T = mi.ScalarTransform4f
RED = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.6, 0.2, 0.1]}}
LIGHT = {"type": "area", "radiance": {"type": "rgb", "value": [1.0, 2.0, 3.0]}}


def room(**changed):
    """Return a shining floor below a red sheet that reflects on both sides."""
    floor = {"type": "rectangle", "to_world": T().scale(2), "emitter": LIGHT, "bsdf": RED}
    sheet = {"type": "rectangle", "to_world": T().translate([0, 0, 1]), "bsdf": {"type": "twosided", "bsdf": RED}}
    return mi.load_dict({"type": "scene", "floor": floor, "sheet": sheet, **changed})


@pytest.mark.parametrize("cuts", [1, 2, 3, 7])
def test_cells_of_a_face(cuts):
    centres = cell_centres(cuts)
    assert len(centres) == cuts**2
    found = cell_of(mi.Point2f(*centres.T.astype(np.float32)), mi.UInt32(cuts))
    assert found.numpy().tolist() == list(range(cuts**2))
    generator = np.random.default_rng(2)
    u, v = generator.random((2, 40000))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    found = cell_of(mi.Point2f(u.astype(np.float32), v.astype(np.float32)), mi.UInt32(cuts)).numpy()
    counts = np.bincount(found, minlength=cuts**2)
    assert len(counts) == cuts**2
    assert np.abs(counts / 40000 * cuts**2 - 1).max() < 6 * cuts / 200  # equal areas, at 6 standard errors
    offset = np.stack([u, v], axis=-1) - centres[found]
    assert np.abs(offset).max() <= 2 / 3 / cuts + 1e-6


def test_sides_materials_and_lights():
    patches = cut(room())
    assert len(patches) == 2 + 2 + 2  # of two triangles each: floor, front and back of the sheet
    floor = patches.centres[:, 2] < 0.5
    assert patches.areas == pytest.approx(np.where(floor, 8, 2))
    assert patches.normals[:, 2] == pytest.approx([1, 1, 1, 1, -1, -1])  # fronts, then backs
    assert not floor[4:].any()
    assert patches.albedo == pytest.approx(np.tile([0.6, 0.2, 0.1], (6, 1)), rel=1e-5)
    assert patches.emitted[floor] == pytest.approx(np.pi * np.tile([1, 2, 3], (2, 1)), rel=1e-5)
    assert patches.emitted[~floor].max() == 0
    assert patches.not_diffuse == []


@pytest.mark.parametrize("size", [None, 0.7, 0.2])
def test_rays_find_their_patch(size):
    patches = cut(room(), size)
    start = patches.centres + 0.3 * patches.normals
    ray = mi.Ray3f(mi.Point3f(*start.T.astype(np.float32)), mi.Vector3f(*(-patches.normals).T.astype(np.float32)))
    assert patches.find(ray).numpy().tolist() == list(range(len(patches)))
    assert patches.areas.sum() == pytest.approx(16 + 8)
    below = mi.Ray3f(mi.Point3f(1.5, 1.5, -1), mi.Vector3f(0, 0, 1))
    assert patches.find(below).numpy().tolist() == [NOTHING]  # the floor has no back
    seen, radiance = patches.see(patches.emitted)(mi.Ray3f(mi.Point3f(1.5, 1.5, 1), mi.Vector3f(0, 0, -1)))
    assert patches.centres[seen.numpy()[0], 2] == pytest.approx(0)
    assert np.ravel(radiance) == pytest.approx([1, 2, 3], rel=1e-5)


def test_edges_are_no_longer_than_asked():
    patches = cut(room(), 0.5)
    assert len(patches) == 2 * 12**2 + 2 * 2 * 6**2  # the diagonals of 4 and of 2


def test_surroundings_shine_where_rays_miss():
    patches = cut(room(sky={"type": "constant", "radiance": {"type": "rgb", "value": [4.0, 5.0, 6.0]}}))
    up = mi.Ray3f(mi.Point3f(0, 0, 3), mi.Vector3f(0, 0, 1))
    patch, radiance = patches.see(patches.emitted)(up)
    assert patch.numpy().tolist() == [NOTHING]
    assert np.ravel(radiance) == pytest.approx([4, 5, 6], rel=1e-5)


def test_what_is_not_diffuse_is_named():
    patches = cut(room(mirror={"type": "rectangle", "bsdf": {"type": "conductor"}, "id": "mirror"}))
    assert patches.not_diffuse == ["'mirror'"]


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        (
            {"wire": {"type": "sdfgrid", "grid": mi.TensorXf(np.linspace(-1, 1, 8).reshape(2, 2, 2, 1))}},
            "these shapes are none: 'wire'",
        ),
        ({"lamp": {"type": "point"}}, "and the light 'lamp' does not"),
        ({"floor": {"type": "rectangle"}}, "There is no light"),
        (
            {"snow": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 1.1}}},
            "more than all; make it less",
        ),
    ],
)
def test_what_has_no_radiosity(changed, sentence):
    with pytest.raises(SceneError, match=sentence):
        cut(room(**changed))


def test_too_many_patches():
    with pytest.raises(SceneError, match="allow longer ones"):
        cut(room(), 1e-4)


@pytest.mark.parametrize("size", [1e-10, 1e-30])
@pytest.mark.parametrize("shape", ["rectangle", "cylinder"])
def test_edges_that_are_no_use(size, shape):
    with pytest.raises(SceneError, match="allow longer ones"):
        cut(mi.load_dict({"type": "scene", "sky": {"type": "constant"}, "shape": {"type": shape}}), size)


def line(reach=1.0):
    """Return a mesh whose only face is a line, or a tiny triangle."""
    mesh = mi.Mesh("line", 3, 1)
    parameters = mi.traverse(mesh)
    corners = [[0, 0, 0], [1, 0, 0], [2, 0, 0]] if reach == 1 else [[0, 0, 0], [reach, 0, 0], [0, reach, 0]]
    parameters["vertex_positions"] = np.array(corners, np.float32).ravel()
    parameters["faces"] = np.array([0, 1, 2], np.uint32)
    parameters.update()
    return mesh


@pytest.mark.parametrize("reach", [1.0, 1e-13])
def test_shapes_without_area(reach):
    sky = {"type": "constant"}
    with pytest.raises(SceneError, match="no face of the scene has an area"):
        cut(mi.load_dict({"type": "scene", "sky": sky, "line": line(reach)}))
    patches = cut(mi.load_dict({"type": "scene", "sky": sky, "line": line(reach), "floor": {"type": "rectangle"}}), 0.5)
    found = solve(patches, 64, spread=Guidance())
    assert found.radiosity == pytest.approx(np.full(found.radiosity.shape, np.pi / 2), rel=1e-3)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_light_that_is_no_number(value):
    mesh = mi.load_dict({"type": "rectangle", "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}})
    parameters = mi.traverse(mesh)
    parameters["emitter.radiance.value"] = mi.Color3f(value)
    parameters.update()
    with pytest.raises(SceneError, match="no finite number"):
        cut(mi.load_dict({"type": "scene", "lamp": mesh}))


def test_faces_without_area_are_no_patches():
    mesh = mi.Mesh("flat", 4, 3)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]], np.float32).ravel()
    parameters["faces"] = np.array([[0, 1, 3], [0, 1, 2], [1, 1, 2]], np.uint32).ravel()
    parameters.update()
    patches = cut(mi.load_dict({"type": "scene", "light": {"type": "constant"}, "mesh": mesh}), 0.4)
    assert len(patches) == 16
    assert patches.areas.sum() == pytest.approx(0.5)
    assert np.isfinite(patches.normals).all()
    ray = mi.Ray3f(mi.Point3f(0.2, 0.2, 1), mi.Vector3f(0, 0, -1))
    assert patches.centres[patches.find(ray).numpy()[0]] == pytest.approx([0.2, 0.2, 0], abs=0.2)


def test_three_faces_at_one_edge():
    mesh = mi.Mesh("fan", 5, 3)
    parameters = mi.traverse(mesh)
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]]
    parameters["vertex_positions"] = np.array(corners, np.float32).ravel()
    parameters["faces"] = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]], np.uint32).ravel()
    parameters.update()
    patches = cut(mi.load_dict({"type": "scene", "light": {"type": "constant"}, "mesh": mesh}))
    assert len(patches) == 3
    found = solve(patches, 64).radiosity
    assert np.isfinite(found).all()
