"""The vertices of meshes that a view sees: those within its image that nothing hides."""

from __future__ import annotations

from collections.abc import Iterator

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.surfaces import Subject

MOST_VERTICES = 1 << 20
"""A wavefront holds at most this many pairs of a viewpoint and a vertex, or else a single viewpoint."""
PRECISION = 1e-5
"""Places are exact to this share of their coordinates and of the distance to them.

It is some 80 steps of single precision. A hit that is nearer than this to a vertex does not hide the vertex.
"""


def seen_vertices(subject: Subject, viewpoints: Viewpoints, lens: Lens) -> Iterator[Integers]:
    """Yield for each viewpoint the numbers (K,), as in ``Mesh.joined``, of the vertices that it sees.

    A vertex is seen from both sides of its faces, which do not hide it. Shapes that are no meshes hide vertices, too.
    """
    places = subject.mesh.places
    size = max(1, MOST_VERTICES // max(len(places), 1))
    for first in range(0, len(viewpoints), size):
        yield from (np.flatnonzero(seen) for seen in see_all(subject, places, viewpoints[first : first + size], lens))


def see_all(subject: Subject, places: Floats, viewpoints: Viewpoints, lens: Lens) -> NDArray[np.bool_]:
    """Return (V, N) whether each viewpoint sees each of ``places`` (N, 3)."""
    axes = np.stack([viewpoints.right, viewpoints.up, -viewpoints.forward], axis=1)
    start, inside = lens.toward((places - viewpoints.eyes[:, None]) @ axes.transpose(0, 2, 1))
    origin = viewpoints.eyes[:, None] + start @ axes
    way = places - origin
    distance = np.linalg.norm(way, axis=-1)
    inside = inside & (distance > 0)
    way = np.where(inside[..., None], way / np.maximum(distance, 1e-300)[..., None], [0.0, 0.0, 1.0])
    slack = PRECISION * (distance + np.abs(places).max(axis=-1) + np.abs(origin).max(axis=-1))
    ray = mi.Ray3f(
        mi.Point3f(*(upload(mi.Float, origin[..., k].ravel()) for k in range(3))),
        mi.Vector3f(*(upload(mi.Float, way[..., k].ravel()) for k in range(3))),
    )
    intersection = subject.scene.ray_intersect_preliminary(ray)
    reached = np.asarray(intersection.t.numpy(), np.float64).reshape(distance.shape)  # infinite where nothing is hit
    hidden = intersection.is_valid().numpy().reshape(distance.shape) & (reached < distance - slack)
    return np.asarray(inside & ~hidden)
