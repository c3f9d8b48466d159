"""Projected area of every surface from viewpoints: which surface each ray of an image hits, added up.

Two ways. *Dense*: a grid of rays, the same for every viewpoint; accurate. *Fast*: random rays, as many as the person
wants, with a standard error (the paper, section 3.2). Both trace many viewpoints in one wavefront. What is kept does
not grow with the number of viewpoints: results come batch by batch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.device import divide, gather_rows, to_unit
from tracer.core.hashing import GOLDEN_RATIO, mix
from tracer.core.sphere import frame
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.surfaces import Subject

Singles = NDArray[np.float32]
MOST_RAYS = 1 << 22
"""Rays in one wavefront."""
MOST_AREAS = 1 << 24
"""Numbers that a batch keeps: viewpoints times surfaces."""
UNITS = 1 << 24
"""Weights are added up in parts of the largest: as many as float32 can tell apart."""


@dataclass(frozen=True)
class Viewpoints:
    """Places to look from, and where to look."""

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
    """How many rays leave a viewpoint: a grid ``side`` rays wide, or ``random`` ones of a ``seed``."""

    side: int = 0
    random: int = 0
    seed: int = 0

    def rows(self, lens: Lens) -> int:
        """Return how many rows the grid has: ``side``, but in an image that is not square."""
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
    """(B, rows, side): distance along the viewing direction, infinite for background; where pictures were asked for."""


def around(centre: Floats, distance: float, directions: Floats, up: Floats | None = None) -> Viewpoints:
    """Return viewpoints at ``distance`` from ``centre`` in ``directions`` (V, 3) that look at it."""
    right, upward = frame(-directions) if up is None else frame(-directions, up)
    return Viewpoints(centre + distance * directions, -directions, right, upward)


def at(places: Floats) -> Viewpoints:
    """Return viewpoints at ``places`` (V, 3) for a lens that sees all directions: its z is that of the world."""
    axes = np.broadcast_to(np.eye(3)[:, None], (3, *places.shape))
    return Viewpoints(places, -axes[2], axes[0], axes[1])


def projected_areas(
    subject: Subject, viewpoints: Viewpoints, lens: Lens, rays: Rays, pictures: bool = False
) -> Iterator[Batch]:
    """Yield the projected areas of all surfaces, batch by batch; what the image has beyond them is background.

    Sums are of integers, so that they do not depend on the order in which threads add, nor on the size of batches.
    ``pictures``: with depth, which needs a grid of rays.
    """
    each = rays.count(lens)
    size = max(1, min(MOST_RAYS // each, MOST_AREAS // subject.count))
    # So that rays which all hit add up to the whole image: a grid's weights have not quite the mean of the lens.
    mean_weight = lens.image_area if rays.random else lens.mean_weight(rays.side, rays.rows(lens))
    area_of_unit = lens.image_area / mean_weight * lens.most / UNITS / each
    for first in range(0, len(viewpoints), size):
        some = viewpoints[first : first + size]
        total = dr.zeros(mi.UInt64, len(some) * subject.count)
        depths = []
        for begin in range(0, each, MOST_RAYS):
            part = trace(subject, some, lens, rays, first, begin, min(MOST_RAYS, each - begin))
            number = part.viewpoint * dr.opaque(mi.UInt32, subject.count) + part.surface
            units = mi.UInt64(part.weight * dr.opaque(mi.Float, UNITS / lens.most))
            # Rays of a wavefront hit so many surfaces that to add them up before scattering only costs.
            dr.scatter_add(total, units, number, part.hit, mode=dr.ReduceMode.Direct)
            depth = dr.select(part.hit, part.depth, dr.inf)
            dr.eval(total, depth if pictures else None)
            depths += [depth.numpy().reshape(len(some), -1)] if pictures else []
        areas = mi.Float(mi.Float64(total) * dr.opaque(mi.Float64, area_of_unit))
        images = np.concatenate(depths, axis=1).reshape(-1, rays.rows(lens), rays.side) if pictures else None
        yield Batch(first, np.asarray(areas.numpy()).reshape(len(some), subject.count), images)


@dataclass(frozen=True)
class Traced:
    """What rays hit, one entry a ray (device arrays, not evaluated)."""

    viewpoint: Any
    """Number within the batch."""
    hit: Any
    surface: Any
    depth: Any
    """Distance along the viewing direction from the eye."""
    weight: Any
    """Part of the image that the ray stands for, times the number of rays."""


def trace(
    subject: Subject, viewpoints: Viewpoints, lens: Lens, rays: Rays, first: int, begin: int, count: int
) -> Traced:
    """Trace the rays ``begin`` to ``begin + count`` of each viewpoint; ``first`` is the number of the first of them."""
    lane = dr.arange(mi.UInt32, len(viewpoints) * count)
    viewpoint, k = divide(lane, count)
    k += dr.opaque(mi.UInt32, begin)
    if rays.random:
        key = mix(mix(mi.UInt32(rays.seed)) ^ (viewpoint + dr.opaque(mi.UInt32, first)))
        u, v = to_unit(mix(key ^ mix(2 * k))), to_unit(mix(key ^ mix(2 * k + 1)))
    elif lens.wraps:
        # A Fibonacci lattice: rows of a grid would all begin and end at the same edges of what is seen.
        u, v = to_unit(k * GOLDEN_RATIO), (mi.Float(k) + 0.5) * dr.opaque(mi.Float, 1 / rays.count(lens))
    else:
        row, column = divide(k, rays.side)
        wide, high = dr.opaque(mi.Float, 1 / rays.side), dr.opaque(mi.Float, 1 / rays.rows(lens))
        u, v = (mi.Float(column) + 0.5) * wide, (mi.Float(row) + 0.5) * high
    ray, weight = world_ray(viewpoints, lens, viewpoint, u, v, even=rays.random > 0)
    found = subject.scene.ray_intersect_preliminary(ray, coherent=not rays.random)
    from_eye = ray.o - gather_rows(viewpoints.eyes, viewpoint)
    depth = dr.dot(from_eye + found.t * ray.d, gather_rows(viewpoints.forward, viewpoint))
    return Traced(viewpoint, found.is_valid(), subject.surface(found), depth, weight)


def world_ray(
    viewpoints: Viewpoints, lens: Lens, viewpoint: Any, u: Any, v: Any, even: bool = False
) -> tuple[Any, Any]:
    """Return the rays, and their weights, of viewpoints (mi.UInt32) at places (u, v) of the lens.

    ``even``: such that all weights are the same.
    """
    origin, direction, weight = lens.random_ray(u, v) if even else lens.ray(u, v)
    eye, right, up, forward = (
        gather_rows(rows, viewpoint) for rows in (viewpoints.eyes, viewpoints.right, viewpoints.up, viewpoints.forward)
    )
    toward = direction.x * right + direction.y * up - direction.z * forward
    start = eye + origin.x * right + origin.y * up - origin.z * forward
    return mi.Ray3f(mi.Point3f(start), toward), weight
