"""What light shows: values from the form factor of a small light, and views of what is neither dark nor burnt out."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.errors import SceneError
from tracer.viewpoint.direction_measure import Gauge, stand
from tracer.viewpoint.item_buffer import Rays, projected_areas
from tracer.viewpoint.light import places_on_mesh, places_on_shape, shown_by_light, weighted_by_light
from tracer.viewpoint.surfaces import open_subject

TURN = mi.ScalarTransform4f


def plate(place, scale=0.01, reflectance=0.5, **more):
    transform = TURN().translate(place).scale(scale)
    return {
        "type": "rectangle",
        "to_world": transform,
        "bsdf": {"type": "diffuse", "reflectance": reflectance},
        **more,
    }


def test_small_plates_under_a_point_light():
    # E = I cos / d^2, L = reflectance E / pi; one plate is shaded by a roof.
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "near": plate([0, 0, 0]),
            "far": plate([2, 0, 0], reflectance=0.8),
            "shaded": plate([-2, 0, 0]),
            "roof": plate([-1.5, 0, 0.5], 0.1, 0.0),
            "light": {"type": "point", "position": [0, 0, 2], "intensity": 3.0},
        },
        optimize=False,
    )
    subject = open_subject(scene, "shape")
    shown = dict(zip(subject.names, shown_by_light(subject), strict=True))
    sent = {"near": 0.5 / np.pi * 3 / 4, "far": 0.8 / np.pi * 3 / 8 * np.cos(np.pi / 4), "shaded": 0, "roof": 0}
    for name, luminance in sent.items():  # from below nothing is lit
        expected = luminance ** (1 / 3) * (1 - luminance) / (0.25 ** (1 / 3) * 0.75)
        assert shown[name] == pytest.approx([expected, 0], rel=1e-3, abs=1e-3)


def test_a_mean_grey_is_shown_best_and_what_is_burnt_out_not_at_all():
    """In the same light from all around, a plate sends out its reflectance times that light."""
    luminances = {"dark": 0.02, "best": 0.25, "pale": 0.8, "burnt": 1.8}
    plates = {
        name: plate([100 * k, 0, 0], reflectance=luminance / 2)
        for k, (name, luminance) in enumerate(luminances.items())
    }
    light = {"type": "constant", "radiance": 2.0}
    scene = mi.load_dict({"type": "scene", **plates, "light": light}, optimize=False)
    subject = open_subject(scene, "shape")
    shown = dict(zip(subject.names, shown_by_light(subject)[:, 0], strict=True))
    assert shown["best"] == pytest.approx(1, abs=0.01)
    assert shown["dark"] == pytest.approx(0.08 ** (1 / 3) * 0.98 / 0.75, rel=0.05)
    assert shown["pale"] == pytest.approx(3.2 ** (1 / 3) * 0.2 / 0.75, rel=0.15)
    assert shown["burnt"] == 0


def test_the_dark_side_of_a_plate_counts_nothing():
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "floor": plate([0, 0, 0], 1.0),
            "light": {"type": "point", "position": [0, 0, 2], "intensity": 3.0},
        }
    )
    subject = weighted_by_light(open_subject(scene, "shape"))
    assert subject.names == ["floor", "floor (back)"]
    place = stand(subject)
    above_and_below = np.array([[0.3, 0.3, 0.9], [0.3, 0.3, -0.9]])
    views = place.viewpoints(above_and_below)
    (batch,) = projected_areas(subject, views, place.lens, Rays(side=64))
    assert np.array_equal(batch.areas > 0, [[True, False], [False, True]])
    assert batch.areas[0, 0] == pytest.approx(batch.areas[1, 1], rel=1e-2)
    values = Gauge(subject, place, Rays(side=64), "entropy").better(above_and_below)
    assert values[0] > values[1]


def test_light_leads_to_the_lit_side():
    # Ten small cubes behind a wall lie in the dark; two in front of it are lit.
    white = {"type": "diffuse"}
    cubes = {
        f"cube{k}": {
            "type": "cube",
            "to_world": TURN().translate([0.5 * (k % 5) - 1, 0.6 * (k // 5) - 0.3, -0.6]).scale(0.15),
            "bsdf": white,
        }
        for k in range(10)
    }
    lit = {
        f"lit{k}": {"type": "cube", "to_world": TURN().translate([k - 0.5, 0, 0.6]).scale(0.2), "bsdf": white}
        for k in range(2)
    }
    wall = {"type": "cube", "to_world": TURN().scale([3, 3, 0.05]), "bsdf": white}
    lamp = {"type": "directional", "direction": [0.2, 0.1, -1], "irradiance": 2.0}
    scene = mi.load_dict(
        {"type": "scene", "integrator": {"type": "path", "max_depth": 3}, **cubes, **lit, "wall": wall, "lamp": lamp}
    )
    subject = open_subject(scene)
    place = stand(subject)
    front_and_back = np.array([[0.3, 0.3, 0.9], [0.3, 0.3, -0.9]])
    by_geometry, by_light = (
        Gauge(each, place, Rays(side=96), "entropy").better(front_and_back)
        for each in (subject, weighted_by_light(subject))
    )
    assert by_geometry[1] > by_geometry[0]
    assert by_light[0] > by_light[1]


def test_light_leads_away_from_what_is_burnt_out():
    """More plates of the front are seen, and all of them are white; those of the back are grey."""
    front = {f"front{k}": plate([0.6 * k - 1.5, 0, 0.2], 0.25) for k in range(6)}
    back = {f"back{k}": plate([0.8 * k - 1.2, 0, -0.2], 0.3) for k in range(4)}
    lamps = {
        f"lamp{k}": {"type": "directional", "direction": [0, 0, -sign], "irradiance": power}
        for k, (sign, power) in enumerate([(1, 20.0), (-1, 1.2)])
    }
    both_sides = {"type": "twosided", "bsdf": {"type": "diffuse"}}
    parts = {name: part | {"bsdf": both_sides} for name, part in (front | back).items()}
    wall = {"type": "cube", "to_world": TURN().scale([3, 3, 0.05]), "bsdf": both_sides}
    integrator = {"type": "path", "max_depth": 2}
    scene = mi.load_dict({"type": "scene", "integrator": integrator, **parts, **lamps, "wall": wall}, optimize=False)
    subject = open_subject(scene, "shape")
    place = stand(subject)
    front_and_back = np.array([[0.0, 0.1, 1], [0, 0.1, -1]])
    by_geometry, by_light = (
        Gauge(each, place, Rays(side=96), "entropy").better(front_and_back)
        for each in (subject, weighted_by_light(subject))
    )
    assert by_geometry[0] > by_geometry[1]
    assert by_light[1] > by_light[0]


def test_places_are_uniform_on_each_surface():
    subject = open_subject(mi.load_dict({"type": "scene", "cube": {"type": "cube"}}), groups=[0] * 4 + [1] * 8)
    points, normals, surface = places_on_mesh(subject, 4000, np.random.default_rng(1))
    assert np.bincount(surface).tolist() == [4000, 4000]
    assert np.all(np.abs(np.abs(points).max(axis=1) - 1) < 1e-6)
    assert np.sum(points * normals, axis=1) == pytest.approx(np.ones(8000))  # outwards, at distance 1
    sides = np.abs(normals[surface == 0]).argmax(axis=1) * np.sign(normals[surface == 0].sum(axis=1))
    counts = np.unique(sides, return_counts=True)[1]
    assert counts == pytest.approx([2000, 2000], abs=5 * np.sqrt(1000))


def test_darkness_is_said():
    dark = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}})
    with pytest.raises(SceneError, match="no light in the scene"):
        shown_by_light(open_subject(dark))
    away = {"type": "spot", "to_world": TURN().look_at([0, 0, 5], [0, 0, 9], [0, 1, 0])}
    with pytest.raises(SceneError, match="reaches no surface"):
        shown_by_light(open_subject(mi.load_dict({"type": "scene", "ball": {"type": "sphere"}, "spot": away})))


def test_that_all_is_burnt_out_is_said():
    sun = {"type": "constant", "radiance": 1e6}
    with pytest.raises(SceneError, match="burnt out, brighter than white"):
        shown_by_light(open_subject(mi.load_dict({"type": "scene", "ball": {"type": "sphere"}, "sun": sun})))


@pytest.mark.parametrize("kind", ["rectangle", "disk", "sphere", "cylinder"])
def test_every_place_on_a_simple_shape_has_a_normal(kind):
    """Of a flat shape Mitsuba returns one normal for all places."""
    points, normals = places_on_shape(mi.load_dict({"type": kind}), 7, np.random.default_rng(1))
    assert points.shape == normals.shape == (7, 3)
    assert np.allclose(np.linalg.norm(normals, axis=-1), 1)
