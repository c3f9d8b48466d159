"""Patches of a scene of meshes: small triangles, each of uniform radiosity.

Every face is cut into n x n triangles, its cells, so that no edge is longer than a given size. The front of a cell is a
patch, and so is its back if any back of the shape reflects or shines. The face that a ray hits, and the place on the
face, determine the patch, so the scene's own geometry is traced and no finer mesh is made.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.radiosity.groups import Points
from tracer.radiosity.hemisphere import NOTHING, See


@dataclass(frozen=True, eq=False)
class Patches:
    """Patches of a scene, numbered from 0: the front of every cell, then the back of every cell that has one."""

    scene: Any
    centres: Floats
    """(P, 3): centres of the patches, in world coordinates."""
    normals: Floats
    """(P, 3): unit normals, on the side of the patch."""
    areas: Floats
    """(P,): areas, in square scene units."""
    albedo: Floats
    """(P, 3): share of evenly incident light that is reflected at the centre, 0 to 1."""
    emitted: Floats
    """(P, 3): power per area that the patch emits."""
    not_diffuse: list[str]
    """Names of shapes whose material is not diffuse; it is treated as a diffuse one of the same albedo."""
    first_face: Any
    """mi.UInt32, by Mitsuba's number of a shape: the number of its first face."""
    first_cell: Any
    """mi.UInt32, by face: the patch on the front of its first cell."""
    cuts: Any
    """mi.UInt32, by face: the number n of parts that its edges are cut into."""
    back: Any
    """mi.UInt32, by cell: the patch on its back, or NOTHING."""
    face: Any
    """mi.UInt32, by patch: the face that the patch is a part of."""

    def __len__(self) -> int:
        return len(self.areas)

    @cached_property
    def front_normals(self) -> Any:
        """Normals of the fronts of all cells as mi.Float: x, y and z of a cell in turn."""
        return upload(mi.Float, self.normals[: dr.width(self.back)])

    @property
    def faces(self) -> int:
        """Number of faces."""
        return int(dr.width(self.cuts))

    @property
    def points(self) -> Points:
        """The centres of the patches, with their normals."""
        return Points(self.centres, self.normals)

    def find(self, ray: Any) -> Any:
        """Return the patch (mi.UInt32) that each ray hits; NOTHING where it misses, or hits a back that is no patch."""
        return self.at(self.scene.ray_intersect_preliminary(ray), ray)

    def at(self, intersection: Any, ray: Any) -> Any:
        """Return the patch (mi.UInt32) of each hit (mi.PreliminaryIntersection3f) of a ray."""
        hit = intersection.is_valid()
        cuts = dr.gather(mi.UInt32, self.cuts, self.face_at(intersection), hit)
        cell = dr.gather(mi.UInt32, self.first_cell, self.face_at(intersection), hit) + cell_of(
            intersection.prim_uv, cuts
        )
        normal = mi.Vector3f(*(dr.gather(mi.Float, self.front_normals, 3 * cell + k, hit) for k in range(3)))
        side = dr.select(dr.dot(normal, ray.d) < 0, cell, dr.gather(mi.UInt32, self.back, cell, hit))
        return dr.select(hit, side, NOTHING)

    def face_at(self, intersection: Any) -> Any:
        """Return the face (mi.UInt32) of each hit."""
        shape = dr.reinterpret_array(mi.UInt32, intersection.shape)
        return dr.gather(mi.UInt32, self.first_face, shape, intersection.is_valid()) + intersection.prim_index

    def see(self, radiosity: Floats, surroundings: bool = True) -> See:
        """Return how rays see a solution: the patch that they hit and its radiance, or the surroundings for a miss.

        ``radiosity`` (P, 3): the solution. ``surroundings``: whether the environment shines; it is dark otherwise.
        """
        table = on_device(radiosity / np.pi)
        around = self.scene.environment() if surroundings else None

        def seen(ray: Any) -> tuple[Any, Any]:
            patch = self.find(ray)
            radiance = look_up(table, patch)
            if around is not None:
                missed = (patch == NOTHING) & ~self.scene.ray_test(ray)
                interaction = dr.zeros(mi.SurfaceInteraction3f, dr.width(ray))
                interaction.wi = -ray.d
                radiance = dr.select(missed, mi.Color3f(around.eval(interaction, missed)), radiance)
            return patch, radiance

        return seen


def by_face(patches: Patches, see: See) -> See:
    """Return how rays see faces instead of patches, so that complexity does not depend on how finely faces are cut."""

    def seen(ray: Any) -> tuple[Any, Any]:
        patch, radiance = see(ray)
        hit = patch != NOTHING
        return dr.select(hit, dr.gather(mi.UInt32, patches.face, patch, hit), NOTHING), radiance

    return seen


def in_cell(place: Any, cuts: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Return the row and column (mi.UInt32) of a cell, the place in it (two mi.Float), and whether its tip is down.

    ``place``: barycentric coordinates (mi.Point2f) on faces that are cut n = ``cuts`` times.
    """
    n, last_row = mi.Float(cuts), dr.maximum(cuts, 1) - 1
    u, v = dr.clip(place.x, 0, 1) * n, dr.clip(place.y, 0, 1) * n
    i = dr.minimum(mi.UInt32(u), last_row)
    j = dr.minimum(mi.UInt32(v), last_row - i)
    u, v = u - mi.Float(i), v - mi.Float(j)
    return i, j, u, v, (u + v > 1) & (i + j < last_row)


def on_device(rows: Floats) -> list[Any]:
    """Return the channels of rows (P, 3), each an mi.Float."""
    return [upload(mi.Float, channel) for channel in rows.T]


def look_up(channels: list[Any], number: Any) -> Any:
    """Return the rows (mi.Color3f) of the given numbers (mi.UInt32); 0 for NOTHING."""
    return mi.Color3f(*(dr.gather(mi.Float, channel, number, number != NOTHING) for channel in channels))


def cell_of(place: Any, cuts: Any) -> Any:
    """Return the cell (mi.UInt32) of barycentric places (mi.Point2f) on faces that are cut n = ``cuts`` times.

    Row i of the n rows has 2 (n - i) - 1 cells, whose tips are up and down in turn.
    """
    i, j, _, _, upper = in_cell(place, cuts)
    return i * (2 * cuts - i) + 2 * j + dr.select(upper, mi.UInt32(1), mi.UInt32(0))
