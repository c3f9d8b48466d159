"""Points where hemispheres stand, and groups of neighbours that see nearly the same.

To look before one gathers takes rays. What one point sees its neighbours see too, so a group looks for all of its
points: each ray that looks leaves from another one of them, and what it costs a point falls as the group grows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.core.hashing import mix

Integers = NDArray[np.int64]
ALIKE = 0.9
"""Cosine that the normals of a group have at least with their mean."""


@dataclass(frozen=True, eq=False)
class Points:
    """Where hemispheres stand."""

    places: Floats
    """(P, 3)."""
    normals: Floats
    """(P, 3), unit."""

    def __len__(self) -> int:
        return len(self.places)

    @cached_property
    def rows(self) -> tuple[Any, Any]:
        """Places and normals as mi.Float, x, y, z in turn."""
        return upload(mi.Float, self.places), upload(mi.Float, self.normals)

    @cached_property
    def outside(self) -> float:
        """How far from the surface rays begin, in units of the largest coordinate."""
        return float(np.abs(self.places).max(initial=0) + 1) * float(mi.math.RayEpsilon)


@dataclass(frozen=True, eq=False)
class Groups:
    """Points in groups of neighbours, G of them."""

    points: Points
    members: Integers
    """(P,): points, group after group."""
    first: Integers
    """(G + 1,): where each group begins in ``members``, and their number."""

    def __len__(self) -> int:
        return len(self.first) - 1

    @cached_property
    def group_of(self) -> Integers:
        """(P,): the group of each point."""
        group = np.empty(len(self.points), np.int64)
        group[self.members] = np.repeat(np.arange(len(self)), np.diff(self.first))
        return group

    @cached_property
    def normals(self) -> Floats:
        """(G, 3): mean of the normals of each group, unit."""
        total = np.add.reduceat(self.points.normals[self.members], self.first[:-1], axis=0)
        return total / np.linalg.norm(total, axis=-1, keepdims=True)

    @cached_property
    def rows(self) -> tuple[Any, Any, Any, Any]:
        """Members, first (mi.UInt32), group_of, and the normals as mi.Float."""
        whole = (upload(mi.UInt32, each) for each in (self.members, self.first, self.group_of))
        return *whole, upload(mi.Float, self.normals)

    def group(self, point: Any) -> Any:
        """Return the group of points (both mi.UInt32)."""
        return dr.gather(mi.UInt32, self.rows[2], point)

    def member(self, group: Any, key: Any) -> Any:
        """Return a point of a group (both mi.UInt32), chosen by random bits."""
        members, first, _, _ = self.rows
        begin = dr.gather(mi.UInt32, first, group)
        size = dr.gather(mi.UInt32, first, group + 1) - begin
        return dr.gather(mi.UInt32, members, begin + mix(key) % size)

    def leave(self, point: Any, local: Any) -> Any:
        """Return rays from points (by number, mi.UInt32) in directions (mi.Vector3f) whose z is the normal."""
        places, own = self.points.rows
        place, normal = (
            mi.Vector3f(*(dr.gather(mi.Float, rows, 3 * point + k) for k in range(3))) for rows in (places, own)
        )
        origin = place + normal * dr.opaque(mi.Float, self.points.outside)
        return mi.Ray3f(mi.Point3f(origin), self.to_world(self.group(point), normal, local))

    def to_world(self, group: Any, normal: Any, local: Any) -> Any:
        """Return directions (mi.Vector3f) in the world of those whose z is a normal.

        The frames of a group differ as little as their normals do: what is up for one is up for all.
        """
        across, along = self.frame(group, normal)
        return across * local.x + along * local.y + normal * local.z

    def to_local(self, group: Any, normal: Any, toward: Any) -> Any:
        """Return what ``to_world`` makes into directions (mi.Vector3f)."""
        across, along = self.frame(group, normal)
        return mi.Vector3f(dr.dot(toward, across), dr.dot(toward, along), dr.dot(toward, normal))

    def frame(self, group: Any, normal: Any) -> tuple[Any, Any]:
        """Return the axes (mi.Vector3f) beside normals."""
        rows = self.rows[3]
        mean = mi.Vector3f(*(dr.gather(mi.Float, rows, 3 * group + k) for k in range(3)))
        across = mi.Frame3f(mean).s
        across -= normal * dr.dot(across, normal)
        # A normal far from those of the group may be that axis itself.
        usual = dr.squared_norm(across) > 1e-4
        across = dr.select(usual, dr.normalize(across), mi.Frame3f(normal).s)
        return across, dr.cross(normal, across)


def alone(points: Points) -> Groups:
    """Return each point as a group of its own: the paper's way."""
    return Groups(points, np.arange(len(points)), np.arange(len(points) + 1))


def neighbours(points: Points, most: int) -> Groups:
    """Return groups of at most ``most`` points that are close, and whose normals are alike.

    Normals that differ are parted in the middle of the axis in which they do most; points, at their median.
    """
    todo, done = [np.arange(len(points))] if len(points) else [], []
    while todo:
        some = todo.pop()
        normals, places = points.normals[some], points.places[some]
        mean = normals.sum(axis=0)
        length = float(np.linalg.norm(mean))
        if not length > 0 or np.any(normals @ mean < ALIKE * length):
            axis = int(np.ptp(normals, axis=0).argmax())
            middle = 0.5 * (normals[:, axis].min() + normals[:, axis].max())
            part = normals[:, axis] > middle
        elif len(some) > most:
            axis = int(np.ptp(places, axis=0).argmax())
            part = np.ones(len(some), bool)
            part[np.argpartition(places[:, axis], len(some) // 2)[: len(some) // 2]] = False
        else:
            part = np.zeros(len(some), bool)
        if part.all() or not part.any():
            done.append(some)
            continue
        todo += [some[part], some[~part]]
    members = np.concatenate([np.zeros(0, np.int64), *done])
    return Groups(points, members, np.cumsum([0, *(len(each) for each in done)]))
