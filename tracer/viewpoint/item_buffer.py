"""The item buffer: projected areas of all surfaces from viewpoints, from the surface that each ray of an image hits.

There are two ways. *Dense*: a grid of rays, the same for every viewpoint; accurate. *Fast*: random rays, as many as the
person wants, with a standard error (the paper, section 3.2). Both trace many viewpoints in one wavefront. Memory does
not grow with the number of viewpoints, as results come batch by batch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Singles
from tracer.core.device import divide, gather_rows, to_unit
from tracer.core.hashing import GOLDEN_RATIO, mix
from tracer.core.sphere import frame
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.surfaces import Subject

MOST_RAYS = 1 << 22
"""A wavefront has at most this many rays."""
MOST_AREAS = 1 << 24
"""A batch has at most this many areas, viewpoints times surfaces, unless a single viewpoint has more."""
UNITS = 1 << 24
"""Weights are added up as integers, and the largest weight is this number: float32 cannot tell more apart."""


@dataclass(frozen=True)
class Viewpoints:
    """V places to look from, and the axes of the view from each. ``tracer.viewpoint.survey.survey`` has an example."""

    eyes: Floats
    """(V, 3)."""
    forward: Floats
    """(V, 3), unit."""
    right: Floats
    """(V, 3), unit."""
    up: Floats
    """(V, 3), unit."""

    def __len__(self) -> int:
        return len(self.eyes)

    def __getitem__(self, part: slice | NDArray[np.int64]) -> Viewpoints:
        return Viewpoints(self.eyes[part], self.forward[part], self.right[part], self.up[part])


@dataclass(frozen=True)
class Rays:
    """The rays that leave a viewpoint: a grid ``side`` rays wide, or as many as ``random``, drawn with ``seed``.

    ``tracer.viewpoint.survey.survey`` has an example.
    """

    side: int = 0
    """Number of rays across the grid; 0 for random rays."""
    random: int = 0
    """Number of random rays; 0 for a grid."""
    seed: int = 0
    """Seed of random rays."""

    def rows(self, lens: Lens) -> int:
        """Return how many rows the grid has: ``side`` in a square image, else more or fewer by its aspect."""
        return max(1, round(self.side / lens.aspect))

    def count(self, lens: Lens) -> int:
        """Return how many rays leave one viewpoint."""
        return self.random or self.side * self.rows(lens)


@dataclass(frozen=True)
class Batch:
    """What was seen from the viewpoints ``first``, ``first + 1``, ..."""

    first: int
    areas: Singles
    """(B, Z): projected area of each surface, in the unit of the lens."""
    depth: Singles | None = None
    """(B, rows, side): distance along the viewing direction, infinite for background; None without pictures."""


def around(centre: Floats, distance: float, directions: Floats, up: Floats | None = None) -> Viewpoints:
    """Return viewpoints at ``distance`` from ``centre`` (3,) in unit ``directions`` (V, 3) that look at it.

    ``up`` (3,): which way is up, z by default. Lengths are in the unit of the scene. ``tracer.viewpoint.survey.survey``
    has an example.
    """
    right, upward = frame(-directions) if up is None else frame(-directions, up)
    return Viewpoints(centre + distance * directions, -directions, right, upward)


def at(places: Floats) -> Viewpoints:
    """Return viewpoints at ``places`` (V, 3) for a lens that sees all directions: its z is that of the world."""
    axes = np.broadcast_to(np.eye(3)[:, None], (3, *places.shape))
    return Viewpoints(places, -axes[2], axes[0], axes[1])


def projected_areas(
    subject: Subject, viewpoints: Viewpoints, lens: Lens, rays: Rays, pictures: bool = False
) -> Iterator[Batch]:
    """Yield the projected areas of all surfaces, batch by batch; the rest of the image is background.

    Integers are added up, so that sums depend neither on the order in which threads add nor on the size of batches.
    ``pictures``: yield depth as well, which needs a grid of rays.
    """
    ray_count = rays.count(lens)
    batch_size = max(1, min(MOST_RAYS // ray_count, MOST_AREAS // subject.count))
    # A grid's mean weight is not quite that of the lens; with its own, rays that all hit add up to the whole image.
    mean_weight = lens.image_area if rays.random else lens.mean_weight(rays.side, rays.rows(lens))
    area_of_unit = lens.image_area / mean_weight * lens.most / UNITS / ray_count
    for first in range(0, len(viewpoints), batch_size):
        views = viewpoints[first : first + batch_size]
        total = dr.zeros(mi.UInt64, len(views) * subject.count)
        depths = []
        for begin in range(0, ray_count, MOST_RAYS):
            traced = trace(subject, views, lens, rays, first, begin, min(MOST_RAYS, ray_count - begin))
            entry = traced.viewpoint * dr.opaque(mi.UInt32, subject.count) + traced.surface
            units = mi.UInt64(traced.weight * dr.opaque(mi.Float, UNITS / lens.most))
            # The rays of a wavefront hit so many different surfaces that adding up before scattering only costs time.
            dr.scatter_add(total, units, entry, traced.hit, mode=dr.ReduceMode.Direct)
            depth = dr.select(traced.hit, traced.depth, dr.inf)
            dr.eval(total, depth if pictures else None)
            depths += [depth.numpy().reshape(len(views), -1)] if pictures else []
        areas = mi.Float(mi.Float64(total) * dr.opaque(mi.Float64, area_of_unit))
        images = np.concatenate(depths, axis=1).reshape(-1, rays.rows(lens), rays.side) if pictures else None
        yield Batch(first, np.asarray(areas.numpy()).reshape(len(views), subject.count), images)


@dataclass(frozen=True)
class Traced:
    """What rays hit: device arrays, not evaluated, with an entry for each ray."""

    viewpoint: Any
    """Number of the viewpoint within the batch."""
    hit: Any
    """Whether a surface was hit, not the background, and nothing that counts as background."""
    surface: Any
    depth: Any
    """Distance along the viewing direction from the eye."""
    weight: Any
    """Area of the image that the ray stands for, times the number of rays."""


def trace(
    subject: Subject, viewpoints: Viewpoints, lens: Lens, rays: Rays, first: int, begin: int, count: int
) -> Traced:
    """Trace the rays ``begin`` to ``begin + count`` of each viewpoint; ``first``: number of the first viewpoint."""
    lane = dr.arange(mi.UInt32, len(viewpoints) * count)
    viewpoint, k = divide(lane, count)
    k += dr.opaque(mi.UInt32, begin)
    if rays.random:
        key = mix(mix(mi.UInt32(rays.seed)) ^ (viewpoint + dr.opaque(mi.UInt32, first)))
        u, v = to_unit(mix(key ^ mix(2 * k))), to_unit(mix(key ^ mix(2 * k + 1)))
    elif lens.wraps:
        # A Fibonacci lattice: the rows of a grid would all begin and end at the same edges of what is seen.
        u, v = to_unit(k * GOLDEN_RATIO), (mi.Float(k) + 0.5) * dr.opaque(mi.Float, 1 / rays.count(lens))
    else:
        row, column = divide(k, rays.side)
        width, height = dr.opaque(mi.Float, 1 / rays.side), dr.opaque(mi.Float, 1 / rays.rows(lens))
        u, v = (mi.Float(column) + 0.5) * width, (mi.Float(row) + 0.5) * height
    ray, weight = world_ray(viewpoints, lens, viewpoint, u, v, even=rays.random > 0)
    intersection = subject.scene.ray_intersect_preliminary(ray, coherent=not rays.random)
    from_eye = ray.o - gather_rows(viewpoints.eyes, viewpoint)
    depth = dr.dot(from_eye + intersection.t * ray.d, gather_rows(viewpoints.forward, viewpoint))
    surface = subject.surface(intersection, ray)
    return Traced(viewpoint, surface < dr.opaque(mi.UInt32, subject.count), surface, depth, weight)


def world_ray(
    viewpoints: Viewpoints, lens: Lens, viewpoint: Any, u: Any, v: Any, even: bool = False
) -> tuple[Any, Any]:
    """Return the rays, and their weights, of the viewpoints numbered ``viewpoint`` (mi.UInt32) at (u, v) of the lens.

    ``even``: spread the rays so that all weights are the same.
    """
    origin, direction, weight = lens.random_ray(u, v) if even else lens.ray(u, v)
    eye, right, up, forward = (
        gather_rows(rows, viewpoint) for rows in (viewpoints.eyes, viewpoints.right, viewpoints.up, viewpoints.forward)
    )
    toward = direction.x * right + direction.y * up - direction.z * forward
    start = eye + origin.x * right + origin.y * up - origin.z * forward
    return mi.Ray3f(mi.Point3f(start), toward), weight
