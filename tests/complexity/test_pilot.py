"""What pilot rays hit, in scenes where it is known."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.adaptive.importance_map import weight_table
from tracer.complexity import measures, pilot
from tracer.core import device
from tracer.sampling.samples import camera_ray
from tracer.scene.view import open_scene

T = mi.ScalarTransform4f


def orthographic(shapes, width=8, height=8):
    """Return a scene seen along -z over [-1, 1]^2."""
    film = {"type": "hdrfilm", "width": width, "height": height}
    sensor = {"type": "orthographic", "to_world": T().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]), "film": film}
    return {"type": "scene", "integrator": {"type": "path"}, "sensor": sensor, "sky": {"type": "constant"}, **shapes}


def measure(scene, rays=4, block=1):
    with open_scene(scene) as view:
        return pilot.measure_complexity(view, mi.load_dict({"type": "owen_sobol"}), 0, rays, block)


def half_plane():
    return {"a": {"type": "rectangle", "to_world": T().translate([-1, 0, 0])}}


def test_an_edge_through_a_block_is_one_bit():
    found = measure(orthographic(half_plane()), rays=4, block=8)
    assert found.shape_entropy == pytest.approx(np.ones((8, 8)), abs=1e-6)
    assert found.shape_gini == pytest.approx(np.full((8, 8), 0.5), abs=1e-6)
    assert found.distinct == pytest.approx(np.full((8, 8), 2))
    # one shape, visible, over half of the block
    assert found.viewpoint == pytest.approx(np.full((8, 8), 1.5), abs=1e-6)


def test_pixels_away_from_edges_are_zero():
    found = measure(orthographic(half_plane()))
    assert np.all(found.shape_entropy == 0)
    assert np.all(found.distinct == 1)


def test_nothing_in_view_is_zero_not_nan():
    found = measure(orthographic({}))
    assert np.all(found.face_entropy == 0)
    assert np.all(found.viewpoint == 0)


def test_faces_differ_within_a_shape_and_meshes_are_not_merged():
    cubes = {
        name: {
            "type": "cube",
            "to_world": T().translate([x, 0, 0]) @ T().scale([0.5, 1, 0.1]),
            "bsdf": {"type": "diffuse"},
        }
        for name, x in (("left", -0.5), ("right", 0.5))
    }
    found = measure(orthographic(cubes), rays=16, block=8)
    assert found.shape_entropy == pytest.approx(np.ones((8, 8)), abs=1e-6)
    # two cubes, of each the front side of two triangles
    assert found.face_entropy == pytest.approx(np.full((8, 8), 2), abs=0.02)


def test_instances_are_told_apart():
    group = {"type": "shapegroup", "first": {"type": "cube", "to_world": T().scale([0.5, 1, 0.1])}}
    scene = orthographic({})
    scene["group"] = group
    for name, x in (("left", -0.5), ("right", 0.5)):
        reference = {"type": "ref", "id": "group"}
        scene[name] = {"type": "instance", "shapegroup": reference, "to_world": T().translate([x, 0, 0])}
    assert measure(scene, block=8).shape_entropy == pytest.approx(np.ones((8, 8)), abs=1e-6)


@pytest.mark.parametrize(("width", "height", "block"), [(8, 8, 1), (8, 8, 2), (7, 5, 4), (3, 2, 8)])
def test_blocks_cover_the_image(width, height, block):
    found = measure(orthographic(half_plane(), width, height), block=block)
    assert found.shape_entropy.shape == (height, width)
    for row in range(0, height, block):
        assert np.ptp(found.shape_entropy[row : row + block, :block]) == 0


def test_multiplicity_is_a_count_of_equals():
    ids = np.random.default_rng(0).integers(0, 5, 60).astype(np.uint32)
    found = np.array(device.multiplicity(mi.UInt32(ids), 12)).reshape(5, 12)
    groups = ids.reshape(5, 12)
    assert np.array_equal(found, (groups[:, :, None] == groups[:, None, :]).sum(axis=-1))


def geometry(scene, rays=4, block=1):
    with open_scene(scene) as view:
        return pilot.measure_geometry(view, mi.load_dict({"type": "owen_sobol"}), 0, rays, block)


@pytest.mark.parametrize("angle", [0, 60])
def test_geometry_of_rays_is_the_cosine_over_the_squared_distance(angle):
    near = 0.01  # Mitsuba's near plane, where rays begin
    plane = {"type": "rectangle", "to_world": T().rotate([0, 1, 0], angle) @ T().scale(9)}
    found = geometry(orthographic({"a": plane}), rays=16)
    assert found.shape == (8, 8, 16)
    distance = (np.cos(np.radians(angle)) / found) ** 0.5
    place = distance.mean(axis=(0, 2)) + near - 5  # -z at the middle of each column, left to right
    assert place == pytest.approx(np.tan(np.radians(angle)) * place_of_columns(place), abs=2e-3)


def place_of_columns(place):
    """Return x of the middles of 8 columns over [-1, 1], in the direction in which ``place`` grows."""
    return np.linspace(-0.875, 0.875, 8) * (1 if place[-1] >= place[0] else -1)


def test_geometry_contrast_sees_edges_and_nothing_else():
    # Of each block's rays one half hits at one distance: half of all values are equal, the rest zero.
    found = measure(orthographic(half_plane()), rays=4, block=8)
    assert found.geometry_contrast == pytest.approx(np.full((8, 8), 1 / 8), abs=1e-5)
    found = measure(orthographic(half_plane()))
    assert found.geometry_contrast == pytest.approx(np.zeros((8, 8)), abs=1e-5)


def test_geometry_is_of_the_rays_that_were_counted():
    found = measure(orthographic(half_plane(), 7, 5), rays=3, block=2)
    assert np.array_equal(found.look_at_geometry() > 0, found.hit)


def test_geometry_is_traced_only_when_asked_for(monkeypatch):
    asked = []
    monkeypatch.setattr(pilot, "measure_geometry", lambda *_: asked.append(1) or np.ones((8, 8, 4)))
    found = measure(orthographic(half_plane()))
    assert found.shape_gini.shape == found.face_entropy.shape == (8, 8)
    assert not asked
    assert np.all(found.geometry_contrast == 0)
    assert np.all(found.geometry_contrast == 0)
    assert asked == [1]


def test_geometry_in_slabs_is_the_same(monkeypatch):
    whole = geometry(orthographic(half_plane(), 7, 5), rays=2, block=2)
    monkeypatch.setattr(pilot, "MOST_RAYS", 40)
    assert np.array_equal(geometry(orthographic(half_plane(), 7, 5), rays=2, block=2), whole)


def test_the_cosine_of_a_back_side_is_that_of_its_front():
    """A plane at z = 0 seen from z = 5, from behind: 1 / 5^2, but for the near plane."""
    plane = {"type": "rectangle", "to_world": T().rotate([0, 1, 0], 180) @ T().scale(9)}
    assert geometry(orthographic({"a": plane})) == pytest.approx(1 / 25, rel=0.01)


def test_faces_of_one_number_differ_from_shape_to_shape():
    """Two triangles each: with the number alone there would be two faces instead of four."""
    found = measure(orthographic(two_cubes()), rays=16, block=8)
    assert found.distinct == pytest.approx(np.full((8, 8), 2))
    assert measures.ray_distinct(found.same_face) == pytest.approx(np.full((1, 1), 4))


def two_cubes():
    size = T().scale([0.5, 1, 0.1])
    places = {"left": -0.5, "right": 0.5}
    return {name: {"type": "cube", "to_world": T().translate([x, 0, 0]) @ size} for name, x in places.items()}


def test_no_two_faces_have_the_same_id():
    instance, shape, face = (mi.UInt32(axis.ravel().astype(np.uint32)) for axis in np.indices((4, 40, 40)))
    shape_id, face_id = (array.numpy() for array in pilot.surface_ids(instance, shape, face))
    assert len(np.unique(shape_id)) == 4 * 40
    assert len(np.unique(face_id)) == 4 * 40 * 40
    assert pilot.MISS not in shape_id
    assert pilot.MISS not in face_id


def test_rays_in_slabs_are_the_same(monkeypatch):
    """Each row of blocks has rays of its own, wherever a slab begins."""
    scene = orthographic(
        {"a": {"type": "rectangle", "to_world": T().rotate([0, 0, 1], 30).translate([-1, 0, 0])}}, 7, 9
    )
    whole = measure(scene, rays=2, block=2)
    monkeypatch.setattr(pilot, "MOST_RAYS", 40)
    parts = measure(scene, rays=2, block=2)
    assert np.array_equal(parts.hit, whole.hit)
    assert np.array_equal(parts.same_face, whole.same_face)


def test_pilot_rays_are_not_those_of_the_picture():
    """Those that decided would be counted once more: positions in the film, of two rays of each pixel."""
    with open_scene(orthographic(half_plane())) as view:
        sampler = mi.load_dict({"type": "owen_sobol"})
        ray = pilot.pilot_rays(view, sampler, 3, 2, 1, 0, 8, 8)
        pixel, index = (mi.UInt32(each) for each in (np.repeat(np.arange(64), 2), np.tile(np.arange(2), 64)))
        sampler.seed_samples(mi.UInt32(3), pixel, index)
        own = camera_ray(view, sampler, pixel // 8, pixel % 8)[0]
        places = [np.array(each.o)[:2] for each in (ray, own)]
    assert np.abs(places[0] - places[1]).max() < 2 * 2 / 8  # both are in their pixels, 1/4 wide
    assert np.abs(places[0] - places[1]).mean() > 0.05


def test_the_mean_over_shapes_goes_by_instances_and_leaves_one_where_nothing_is_named():
    scene = orthographic(
        {"group": {"type": "shapegroup", "first": {"type": "cube", "to_world": T().scale([0.5, 1, 0.1])}}}
    )
    for name, x in (("left", -0.5), ("right", 0.5)):
        place = T().translate([x, 0, 0]) @ T().scale([1, 0.5, 1])
        scene[name] = {"type": "instance", "shapegroup": {"type": "ref", "id": "group"}, "to_world": place}
    with open_scene(scene) as view:
        sampler = mi.load_dict({"type": "owen_sobol"})
        table = weight_table(view, {"left": 3.0, "right": 5.0})
        found = pilot.mean_over_shapes(view, sampler, 0, 4, table)
    assert np.all(found[[0, 1, 6, 7]] == 1)
    assert sorted([found[3, 1], found[3, 6]]) == [3, 5]
    assert np.ptp(found[2:6, :4]) == np.ptp(found[2:6, 4:]) == 0


def test_blocks_at_the_edge_do_not_look_beyond_the_image():
    """4 rows of 8 pixels show -0.5 to 0.5; a plane below would be seen by the lower half of a block of 8."""
    below = {"type": "rectangle", "to_world": T().translate([0, -1.5, 0])}
    assert not measure(orthographic({"a": below}, 8, 4), block=8).hit.any()
    inside = {"type": "rectangle", "to_world": T().translate([0, -1.4, 0])}
    assert measure(orthographic({"a": inside}, 8, 4), block=8).hit.any()
