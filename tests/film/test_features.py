"""Features along the rays of the picture, and the numbers of shapes."""

import mitsuba as mi
import numpy as np
import pytest

import tracer
from conformance.cases import sensors
from plugins.test_features import room, wall
from tracer.film.features import FeatureView, draw_features, shape_numbers
from tracer.scene.view import open_scene

T = mi.ScalarTransform4f


def sampler():
    return mi.load_dict({"type": "owen_sobol"})


def full(view, count):
    return np.full(view.grid, count, np.uint32)


def stacked(features):
    return np.concatenate([features.albedo, features.normal, features.depth[..., None]], axis=-1)


@pytest.mark.parametrize("sensor", ["perspective", "thinlens", "orthographic", "shutter"])
@pytest.mark.parametrize("film", [{}, {"sample_border": True}, {"crop_offset_x": 5, "crop_width": 9}])
def test_rays_are_those_of_the_picture(sensor, film):
    """Mitsuba's own AOVs, beside a picture drawn by our loop with the same seed, see the same."""
    scene = room(size=16) | {"sensor": room(16)["sensor"] | film_of(film)}
    if sensor != "perspective":
        scene["sensor"] = sensors()[sensor] | {"film": scene["sensor"]["film"]}
    aov = {"type": "aov", "aovs": "a:albedo,n:sh_normal,d:depth", "picture": {"type": "path", "max_depth": 3}}
    expected = tracer.render(scene, integrator=aov, criterion="uniform", spp=8, seed=7).image[..., -7:]
    with open_scene(scene) as view:
        found = draw_features(view, sampler(), 7, full(view, 8))
        others = draw_features(view, sampler(), 8, full(view, 8))
    assert found.depth.dtype == found.albedo.dtype == found.normal.dtype == np.float32
    assert found.depth.shape == view.size
    assert stacked(found) == pytest.approx(expected, abs=2e-5)
    assert np.abs(stacked(others) - expected).max() > 0.01


def film_of(film):
    return {"film": room(16)["sensor"]["film"] | film}


def test_no_more_rays_than_the_picture_or_than_most():
    with open_scene(room()) as view:
        counts = np.random.default_rng(1).integers(0, 60, view.grid).astype(np.uint32)
        found = draw_features(view, sampler(), 3, counts, most=16)
        fewer = draw_features(view, sampler(), 3, np.minimum(counts, 16), most=99)
    assert np.array_equal(stacked(found), stacked(fewer))


def test_pixels_without_samples_are_zero():
    with open_scene(wall()) as view:
        counts = full(view, 4)
        counts[:, -2:] = 0
        found = draw_features(view, sampler(), 0, counts)
        nothing = draw_features(view, sampler(), 0, 0 * counts)
    assert np.all(stacked(found)[:, -2:] == 0)
    assert not stacked(nothing).any()


def test_a_wall_at_a_known_distance():
    with open_scene(wall({"type": "diffuse", "reflectance": 0.25})) as view:
        found = draw_features(view, sampler(), 0, full(view, 8))
    left = np.arange(8) < 4
    assert stacked(found)[:, ~left] == pytest.approx(0)
    assert stacked(found)[:, left] == pytest.approx(np.tile([0.25, 0.25, 0.25, 0, 0, 1, 1.5], (4, 4, 1)))


def test_view_and_sampler_are_left_alone():
    with open_scene(room()) as view:
        used, channels = sampler(), list(view.channels)
        draw_features(view, used, 0, full(view, 1))
        assert view.channels == channels
        assert vars(used).keys() == vars(sampler()).keys()
        assert FeatureView(view.scene, view.sensor, mi.load_dict({"type": "features"}), {}).size == view.size


def test_shapes_by_their_number():
    with open_scene(room(size=32)) as view:
        numbers, names = shape_numbers(view)
        assert names == [shape.id() for shape in view.scene.shapes()]
        by_name = {name: numbers == k + 1 for k, name in enumerate(names)}
    assert numbers.shape == (32, 32)
    assert numbers.dtype == np.uint32
    assert by_name["floor"][-2, 16]
    assert by_name["ceiling"][1, 3]
    assert by_name["balls_0"].any()
    assert by_name["balls_1"].any()
    assert sum(seen.sum() for seen in by_name.values()) + (numbers == 0).sum() == 32 * 32


def test_shapes_of_a_crop_are_those_of_the_whole():
    scene = room(size=20)
    with open_scene(scene) as view:
        whole, _ = shape_numbers(view)
    scene["sensor"]["film"] |= {"crop_offset_x": 3, "crop_offset_y": 6, "crop_width": 11, "crop_height": 9}
    scene["sensor"]["film"]["sample_border"] = True
    with open_scene(scene) as view:
        crop, _ = shape_numbers(view)
    assert np.array_equal(crop, whole[6:15, 3:14])


def test_nothing_is_shape_zero():
    with open_scene(wall()) as view:
        numbers, names = shape_numbers(view)
    assert names == ["wall"]
    assert np.array_equal(numbers, np.tile([1, 1, 1, 1, 0, 0, 0, 0], (4, 1)))


@pytest.mark.parametrize("border", [False, True])
def test_unfiltered_is_what_a_box_filter_gives(border):
    scene = room(16)
    scene["sensor"]["film"]["sample_border"] = border
    with open_scene(scene) as view:
        found = draw_features(view, sampler(), 0, full(view, 8), filtered=False)
    scene["sensor"]["film"] |= {"rfilter": {"type": "box"}, "sample_border": False}
    with open_scene(scene) as view:
        expected = draw_features(view, sampler(), 0, full(view, 8))
    if border:  # the same picture, but its pixels have other numbers, so other samples
        assert np.abs(stacked(found) - stacked(expected)).mean() < 0.03
    else:
        assert np.array_equal(stacked(found), stacked(expected))


def test_a_shape_without_a_name_has_that_of_its_class():
    """As meshes that Mitsuba has merged, in a scene that it has loaded itself."""
    camera = wall()["sensor"]
    alike = {"type": "cube", "grey": {"type": "ref", "id": "grey"}}
    cubes = {name: alike | {"to_world": T().translate([x, 0, 0])} for name, x in (("a", -2), ("b", 2))}
    grey = {"type": "diffuse", "id": "grey"}
    scene = mi.load_dict({"type": "scene", "integrator": {"type": "path"}, "sensor": camera, "grey": grey, **cubes})
    assert [shape.id() for shape in scene.shapes()] == [""]
    with open_scene(scene) as view:
        assert shape_numbers(view)[1] == [type(scene.shapes()[0]).__name__]


def test_instances_are_told_apart():
    """Two instances of a cube, left and right of the middle."""
    scene = wall()
    group = {"type": "shapegroup", "first": {"type": "cube", "to_world": T().scale(0.2)}}
    scene = {"type": "scene", "integrator": {"type": "path"}, "sensor": scene["sensor"], "group": group}
    film = {"type": "hdrfilm", "width": 8, "height": 4}
    look = T().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])
    scene["sensor"] = {"type": "orthographic", "to_world": look, "film": film}
    for name, x in (("left", -0.5), ("right", 0.5)):
        place = T().translate([x, 0, 0])
        scene[name] = {"type": "instance", "shapegroup": {"type": "ref", "id": "group"}, "to_world": place}
    with open_scene(scene) as view:
        numbers, names = shape_numbers(view)
    first, second = set(numbers[:, :4].ravel()) - {0}, set(numbers[:, 4:].ravel()) - {0}
    assert len(first) == len(second) == 1
    assert {names[first.pop() - 1], names[second.pop() - 1]} == {"left", "right"}


def test_the_shape_of_a_pixel_is_the_one_at_its_middle():
    """An edge at 0.3 of a pixel, from its left: the middle lies right of it."""
    film = {"type": "hdrfilm", "width": 4, "height": 4}
    look = T().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])
    sensor = {"type": "orthographic", "to_world": look, "film": film}
    found = []
    for part in (0.3, 0.7):
        edge = -1 + (1 + part) / 2  # the second pixel from -0.5 to 0
        right = T().translate([edge + 1, 0, 0])
        plane = {"type": "rectangle", "to_world": right}
        with open_scene({"type": "scene", "integrator": {"type": "path"}, "sensor": sensor, "a": plane}) as view:
            found.append(sorted(shape_numbers(view)[0].sum(axis=0)))
    assert found == [[0, 4, 4, 4], [0, 0, 4, 4]]
