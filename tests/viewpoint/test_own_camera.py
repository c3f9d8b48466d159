"""A scene's own camera: it sees what Mitsuba renders, and its image has the area that geometry gives."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.errors import SceneError
from tracer.viewpoint.item_buffer import Rays, projected_areas
from tracer.viewpoint.own_camera import own_camera
from tracer.viewpoint.surfaces import open_subject

LOOK = mi.ScalarTransform4f().look_at([3, 2, 4], [0.2, -0.1, 0], [0, 1, 0.1])
FILM = {"type": "hdrfilm", "width": 96, "height": 54, "rfilter": {"type": "box"}, "pixel_format": "luminance"}
PERSPECTIVE = {"type": "perspective", "fov": 40, "to_world": LOOK}
SENSORS = {
    "perspective": PERSPECTIVE,
    "shifted": {**PERSPECTIVE, "principal_point_offset_x": 0.2, "principal_point_offset_y": -0.1},
    "near clip": {**PERSPECTIVE, "near_clip": 4.2},
    "thin lens": {**PERSPECTIVE, "type": "thinlens", "aperture_radius": 1e-5, "focus_distance": 4.0},
    "parallel": {
        "type": "orthographic",
        "to_world": LOOK @ mi.ScalarTransform4f().scale([1.5, 1.5, 1]),
    },
}


def scene(sensor):
    shapes = {
        f"ball{k}": {"type": "sphere", "center": [k - 1, 0.4 * k - 0.3, 0.5], "radius": 0.3 + 0.1 * k} for k in range(3)
    }
    floor = {"type": "rectangle", "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(3)}
    return mi.load_dict({"type": "scene", "sensor": {**sensor, "film": FILM}, **shapes, "floor": floor})


@pytest.mark.parametrize("name", SENSORS)
def test_depth_is_that_of_mitsuba(name):
    loaded = scene(SENSORS[name])
    subject = open_subject(loaded, "shape")
    view, lens, size = own_camera(loaded)
    assert size == (96, 54)
    assert lens.parallel == (name == "parallel")
    depth = next(projected_areas(subject, view, lens, Rays(side=96), pictures=True)).depth[0]
    depth = np.nan_to_num(depth, posinf=1e9)
    assert depth.shape == (54, 96)
    integrator = mi.load_dict({"type": "aov", "aovs": "position:position"})
    samples = 256  # so that the mean of a pixel is that of its middle where one surface is seen
    places = np.array(mi.render(loaded, integrator=integrator, spp=samples))[..., -3:].astype(float)
    expected = (places - view.eyes[0]) @ view.forward[0]
    smooth = depth < 1e9
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        smooth &= np.abs(np.roll(depth, step, axis) - depth) < 0.05
    smooth[[0, -1]] = smooth[:, [0, -1]] = False
    assert smooth.sum() > 500
    assert depth[smooth] == pytest.approx(expected[smooth], abs=0.01)


@pytest.mark.parametrize("name", SENSORS)
def test_area_of_the_image(name):
    loaded = scene(SENSORS[name])
    _, lens, _ = own_camera(loaded)
    x, y = np.tan(np.radians(20)) * np.array([1, 54 / 96])
    left, right, low, high = -x, x, -y, y
    if name == "shifted":
        left, right, low, high = (left + 0.4 * x, right + 0.4 * x, low - 0.2 * y, high - 0.2 * y)

    def corner(x, y):
        return np.arctan(x * y / np.sqrt(1 + x * x + y * y))

    solid = corner(right, high) - corner(left, high) - corner(right, low) + corner(left, low)
    # Parallel rays: the window is two units wide before it is scaled by 1.5.
    expected = 9 * 54 / 96 if name == "parallel" else solid
    assert lens.image_area == pytest.approx(expected, rel=2e-4)


def test_what_surrounds_fills_the_image():
    loaded = mi.load_dict(
        {"type": "scene", "sensor": {**PERSPECTIVE, "film": FILM}, "room": {"type": "sphere", "radius": 9}}
    )
    view, lens, _ = own_camera(loaded)
    areas = next(projected_areas(open_subject(loaded), view, lens, Rays(side=100))).areas
    assert areas.sum() == pytest.approx(lens.image_area, rel=1e-6)


def test_no_camera():
    loaded = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}})
    with pytest.raises(SceneError, match="no camera 0: it has none"):
        own_camera(loaded)
    with pytest.raises(SceneError, match="no camera 2: it has 1"):
        own_camera(scene(PERSPECTIVE), 2)
    meter = mi.load_dict(
        {
            "type": "scene",
            "ball": {"type": "sphere"},
            "meter": {"type": "radiancemeter", "film": {**FILM, "width": 1, "height": 1}},
        }
    )
    with pytest.raises(SceneError, match="form no image"):
        own_camera(meter)


@pytest.mark.parametrize("name", SENSORS)
def test_places_are_found_in_the_image(name):
    """Where rays to them start and whether they are within: the reverse of the rays that the sensor sends."""
    _, lens, _ = own_camera(scene(SENSORS[name]))
    generator = np.random.default_rng(3)
    u, v = generator.uniform(-0.2, 1.2, (2, 2000))
    edge = np.maximum(np.abs(u - 0.5), np.abs(v - 0.5))
    origin, direction, _ = lens.ray(mi.Float(u.astype(np.float32)), mi.Float(v.astype(np.float32)))
    origin, direction = (np.array(each, float).T for each in (origin, direction))
    places = origin + generator.uniform(0.5, 5, 2000)[:, None] * direction
    start, inside = lens.toward(places)
    clear = np.abs(edge - 0.5) > 0.002
    assert np.array_equal(inside[clear], edge[clear] < 0.5)
    assert start[inside] == pytest.approx(origin[inside], abs=0.02)
    assert not lens.toward(origin - direction)[1].any()  # before the near plane, or behind
