"""A scene's own camera as a lens: the rays of any Mitsuba sensor, through the middle of its aperture."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tracer.core.arrays import Floats
from tracer.core.device import divide
from tracer.errors import SceneError
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.lens import Lens

STEP = 1 / 1024
"""Central differences of rays take this step to either side, as a share of the side of the image."""
GRID = 128
"""The grid that measures the area of the image, and finds places in it, has this many rays along each side."""


@dataclass(frozen=True, eq=False)
class SensorLens(Lens):
    """A lens with the rays of a sensor, in the frame of ``view``, the viewpoint at the place of the sensor."""

    sensor: Any
    view: Viewpoints
    parallel: bool
    """Whether the weight of a ray is an area, not a solid angle."""
    area: float
    """Area of the image, see ``Lens.image_area``."""
    largest: float
    """Upper limit of the weights, see ``Lens.most``."""
    aspect: float = 1.0

    def ray(self, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """See ``Lens.ray``; the weight comes from differences between rays."""
        ray = world_ray_of(self.sensor, u, v)
        return self.inward(ray.o - mi.Point3f(self.view.eyes[0].tolist())), self.inward(ray.d), self.weight(u, v)

    def inward(self, vector: Any) -> Any:
        """Return a vector of the world in the frame of the view."""
        axes = (self.view.right[0], self.view.up[0], -self.view.forward[0])
        return mi.Vector3f(*(dr.dot(vector, mi.Vector3f(axis.tolist())) for axis in axes))

    def toward(self, places: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """See ``Lens.toward``; one linear step from the nearest ray of a grid leads to the place in the image."""
        distance = np.linalg.norm(places, axis=-1)
        aims = places[..., :2] if self.parallel else places / np.maximum(distance, 1e-300)[..., None]
        origins, tree, steps = self.grid
        nearest = tree.query(aims)[1]
        offset = np.einsum("...kd,...d->...k", steps[nearest], aims - tree.data[nearest])
        place = np.stack([nearest % GRID, nearest // GRID], axis=-1) + offset
        inside = np.all((place >= -0.5) & (place <= GRID - 0.5) & (np.abs(offset) < 2), axis=-1)
        if self.parallel:
            depth = origins[nearest, 2]
            return np.concatenate([aims, depth[..., None]], axis=-1), inside & (places[..., 2] < depth)
        start_distance = np.linalg.norm(origins[nearest], axis=-1)
        return aims * start_distance[..., None], inside & (distance > start_distance)

    @cached_property
    def grid(self) -> tuple[Floats, Any, Floats]:
        """Return (origins, tree, steps) of a grid of rays.

        Origins (GRID^2, 3). A tree of the aims (GRID^2, D) of the rays: their directions, or if they are parallel the
        x and y of their origins. Steps (GRID^2, 2, D): columns and rows of the grid per difference of aims.
        """
        row, column = divide(dr.arange(mi.UInt32, GRID * GRID), GRID)
        origin, direction, _ = self.ray((mi.Float(column) + 0.5) / GRID, (mi.Float(row) + 0.5) / GRID)
        origins, directions = (np.array(vectors, np.float64).T for vectors in (origin, direction))
        aims = origins[:, :2] if self.parallel else directions
        image = aims.reshape(GRID, GRID, -1)
        slopes = np.stack([np.gradient(image, axis=1), np.gradient(image, axis=0)], axis=-1)
        return origins, cKDTree(aims), np.asarray(np.linalg.pinv(slopes.reshape(GRID * GRID, -1, 2)), np.float64)

    def weight(self, u: Any, v: Any) -> Any:
        """Return the solid angle, or for parallel rays the area across them, per area of the square."""
        return weight_of(self.sensor, u, v, self.parallel)

    @property
    def image_area(self) -> float:
        """See ``Lens.image_area``."""
        return self.area

    @property
    def most(self) -> float:
        """See ``Lens.most``."""
        return self.largest

    def mean_weight(self, columns: int, rows: int) -> float:
        """See ``Lens.mean_weight``."""
        return float(grid_weights(self.sensor, columns, rows, self.parallel).mean())


def own_camera(scene: Any, number: int = 0) -> tuple[Viewpoints, SensorLens, tuple[int, int]]:
    """Return (viewpoint, lens, (columns, rows) of the film) of the sensor ``number`` of a scene.

    Raises SceneError if there is no such sensor, or if its rays form no image.
    """
    sensors = scene.sensors()
    if not 0 <= number < len(sensors):
        existing = f"it has {len(sensors)}, numbered from 0" if sensors else "it has none"
        raise SceneError(f"The scene has no camera {number}: {existing}.")
    sensor = sensors[number]
    middle = world_ray_of(sensor, mi.Float(0.5), mi.Float(0.5))
    down = world_ray_of(sensor, mi.Float(0.5), mi.Float(0.5 + 16 * STEP))
    columns, rows = (int(size) for size in sensor.film().crop_size())
    forward, lower = (np.array(ray.d, np.float64).ravel() for ray in (middle, down))
    downward = lower - forward
    if np.linalg.norm(downward) < 1e-7:  # parallel rays differ in their origins alone
        downward = np.array(down.o - middle.o, np.float64).ravel()
    downward -= np.dot(downward, forward) * forward
    if columns * rows < 2 or not np.all(np.isfinite(downward)) or np.linalg.norm(downward) < 1e-12:
        raise SceneError(f"Sensor {number} of the scene is no camera: its rays form no image.")
    forward /= np.linalg.norm(forward)
    up = -downward / np.linalg.norm(downward)
    eye = np.array(sensor.world_transform().translation(), np.float64).ravel()
    view = Viewpoints(eye[None], forward[None], np.cross(forward, up)[None], up[None])
    weights = grid_weights(sensor, GRID, GRID, False)
    parallel = bool(weights.max() < 1e-9)
    if parallel:
        weights = grid_weights(sensor, GRID, GRID, True)
    lens = SensorLens(sensor, view, parallel, float(weights.mean()), 1.1 * float(weights.max()), columns / rows)
    return view, lens, (columns, rows)


def world_ray_of(sensor: Any, u: Any, v: Any) -> Any:
    """Return the rays of a sensor through places (mi.Float) of its image."""
    ray, _ = sensor.sample_ray(mi.Float(0), mi.Float(0.5), mi.Point2f(u, v), mi.Point2f(0.5, 0.5))
    return ray


def weight_of(sensor: Any, u: Any, v: Any, parallel: bool) -> Any:
    """See ``SensorLens.weight``."""
    h = dr.opaque(mi.Float, STEP)
    right, left = world_ray_of(sensor, u + h, v), world_ray_of(sensor, u - h, v)
    below, above = world_ray_of(sensor, u, v + h), world_ray_of(sensor, u, v - h)
    if parallel:
        area = dr.cross(right.o - left.o, below.o - above.o)
        return dr.abs(dr.dot(area, right.d)) / dr.square(2 * h)
    return dr.norm(dr.cross(right.d - left.d, below.d - above.d)) / dr.square(2 * h)


def grid_weights(sensor: Any, columns: int, rows: int, parallel: bool) -> Floats:
    """Return the weights (columns * rows,) of a grid of rays."""
    row, column = divide(dr.arange(mi.UInt32, columns * rows), columns)
    u, v = (mi.Float(column) + 0.5) / columns, (mi.Float(row) + 0.5) / rows
    return np.array(weight_of(sensor, u, v, parallel), np.float64)
