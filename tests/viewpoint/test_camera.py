"""Cameras that are written show what was found, whatever the unit of length."""

import mitsuba as mi
import numpy as np
import pytest

from tracer.core import sphere
from tracer.viewpoint.camera import sensors, write_sensors
from tracer.viewpoint.direction_measure import stand
from tracer.viewpoint.item_buffer import Rays, projected_areas
from tracer.viewpoint.surfaces import open_subject

from .conftest import mesh_scene

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 0.5]])
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 3e3, 1e6])
@pytest.mark.parametrize("orthographic", [False, True])
def test_mitsuba_sees_what_the_item_buffer_sees(scale, orthographic, tmp_path):
    subject = open_subject(mesh_scene(CORNERS * scale, FACES))
    place = stand(subject, orthographic=orthographic)
    view = place.viewpoints(sphere.normalised([[1.0, 0.3, 0.6]]))
    rays = Rays(side=64)
    depth = next(projected_areas(subject, view, place.lens, rays, pictures=True)).depth[0]
    write_sensors(tmp_path / "camera.xml", view, place.lens, 64, place.clip)
    written = mi.load_file(str(tmp_path / "camera.xml")).sensors()[0]
    for sensor in (mi.load_dict(sensors(view, place.lens, 64, place.clip)[0]), written):
        u, v = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(64) + 0.5) / 64)
        sample = mi.Point2f(u.ravel().astype(np.float32), v.ravel().astype(np.float32))
        ray, _ = sensor.sample_ray(mi.Float(0), mi.Float(0.5), sample, mi.Point2f(0.5, 0.5))
        hit = subject.scene.ray_intersect_preliminary(ray).is_valid().numpy().reshape(64, 64)
        assert hit.mean() > 0.05
        assert np.mean(hit != np.isfinite(depth)) < 0.01  # not mirrored either: the tetrahedron is not symmetric
