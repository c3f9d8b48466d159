"""Points with a hemisphere each, and groups of neighbouring points that see nearly the same.

To look before gathering costs rays. Neighbouring points see nearly the same, so a group looks for all of its points:
every ray that looks leaves from a point of the group chosen at random, and the cost for each point falls as the group
grows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.core.hashing import mix

ALIKE = 0.9
"""Smallest cosine between a normal of a group and the mean of its normals."""


@dataclass(frozen=True, eq=False)
class Points:
    """Points of surfaces, each the centre of a hemisphere."""

    places: Floats
    """(P, 3): world coordinates."""
    normals: Floats
    """(P, 3): unit vectors, the axes of the hemispheres."""

    def __len__(self) -> int:
        return len(self.places)

    @cached_property
    def rows(self) -> tuple[Any, Any]:
        """Places and normals as mi.Float, x, y, z in turn."""
        return upload(mi.Float, self.places), upload(mi.Float, self.normals)

    @cached_property
    def outside(self) -> float:
        """Distance from the surface at which rays begin, in scene units; it grows with the largest coordinate."""
        return float(np.abs(self.places).max(initial=0) + 1) * float(mi.math.RayEpsilon)


@dataclass(frozen=True, eq=False)
class Groups:
    """Points in G groups of neighbours."""

    points: Points
    members: Integers
    """(P,): numbers of the points, group after group."""
    first: Integers
    """(G + 1,): where each group begins in ``members``, and as the last entry the number of members."""

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
        """(G, 3): mean of the normals of each group, scaled to unit length."""
        total = np.add.reduceat(self.points.normals[self.members], self.first[:-1], axis=0)
        return total / np.linalg.norm(total, axis=-1, keepdims=True)

    @cached_property
    def rows(self) -> tuple[Any, Any, Any, Any]:
        """``members``, ``first`` and ``group_of`` as mi.UInt32, and ``normals`` as mi.Float."""
        numbers = (upload(mi.UInt32, array) for array in (self.members, self.first, self.group_of))
        return *numbers, upload(mi.Float, self.normals)

    def group(self, point: Any) -> Any:
        """Return the group of each point (both mi.UInt32)."""
        return dr.gather(mi.UInt32, self.rows[2], point)

    def member(self, group: Any, key: Any) -> Any:
        """Return a point of a group (both mi.UInt32), chosen by random bits."""
        members, first, _, _ = self.rows
        begin = dr.gather(mi.UInt32, first, group)
        size = dr.gather(mi.UInt32, first, group + 1) - begin
        return dr.gather(mi.UInt32, members, begin + mix(key) % size)

    def leave(self, point: Any, local: Any) -> Any:
        """Return rays (mi.Ray3f) from points (mi.UInt32, by number) in local directions (mi.Vector3f), z the normal."""
        places, point_normals = self.points.rows
        place, normal = (
            mi.Vector3f(*(dr.gather(mi.Float, coordinates, 3 * point + k) for k in range(3)))
            for coordinates in (places, point_normals)
        )
        origin = place + normal * dr.opaque(mi.Float, self.points.outside)
        return mi.Ray3f(mi.Point3f(origin), self.to_world(self.group(point), normal, local))

    def to_world(self, group: Any, normal: Any, local: Any) -> Any:
        """Return the directions (mi.Vector3f) in the world of local directions, whose z is the normal.

        The frames of the points of a group differ as little as their normals do, so that a local direction means nearly
        the same for all of them.
        """
        across, along = self.frame(group, normal)
        return across * local.x + along * local.y + normal * local.z

    def to_local(self, group: Any, normal: Any, toward: Any) -> Any:
        """Return the local directions (mi.Vector3f) of directions in the world: the inverse of ``to_world``."""
        across, along = self.frame(group, normal)
        return mi.Vector3f(dr.dot(toward, across), dr.dot(toward, along), dr.dot(toward, normal))

    def frame(self, group: Any, normal: Any) -> tuple[Any, Any]:
        """Return the axes x and y (mi.Vector3f) of local frames whose z is the normal."""
        rows = self.rows[3]
        mean = mi.Vector3f(*(dr.gather(mi.Float, rows, 3 * group + k) for k in range(3)))
        across = mi.Frame3f(mean).s
        across -= normal * dr.dot(across, normal)
        # A normal far from the mean of the group may lie along the axis x itself.
        usual = dr.squared_norm(across) > 1e-4
        across = dr.select(usual, dr.normalize(across), mi.Frame3f(normal).s)
        return across, dr.cross(normal, across)


def alone(points: Points) -> Groups:
    """Return groups of one point each, as in the paper."""
    return Groups(points, np.arange(len(points)), np.arange(len(points) + 1))


def neighbours(points: Points, most: int) -> Groups:
    """Return groups of at most ``most`` points that are close together and whose normals are alike.

    Points whose normals differ are parted in the middle of the axis along which the normals differ most; groups that
    are too large are parted at the median of the axis along which the points extend most.
    """
    pending, done = [np.arange(len(points))] if len(points) else [], []
    while pending:
        group = pending.pop()
        normals, places = points.normals[group], points.places[group]
        mean = normals.sum(axis=0)
        length = float(np.linalg.norm(mean))
        if not length > 0 or np.any(normals @ mean < ALIKE * length):
            axis = int(np.ptp(normals, axis=0).argmax())
            middle = 0.5 * (normals[:, axis].min() + normals[:, axis].max())
            is_far = normals[:, axis] > middle
        elif len(group) > most:
            axis = int(np.ptp(places, axis=0).argmax())
            is_far = np.ones(len(group), bool)
            is_far[np.argpartition(places[:, axis], len(group) // 2)[: len(group) // 2]] = False
        else:
            is_far = np.zeros(len(group), bool)
        if is_far.all() or not is_far.any():
            done.append(group)
            continue
        pending += [group[is_far], group[~is_far]]
    members = np.concatenate([np.zeros(0, np.int64), *done])
    return Groups(points, members, np.cumsum([0, *(len(group) for group in done)]))
