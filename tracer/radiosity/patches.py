"""Patches of a scene of meshes: what is lit, reflects and shines alike.

Every face is cut into n x n triangles, so that none has an edge longer than asked for. A side that reflects or shines
is a patch of its own. Rays find their patch from the face and the place on it that they hit; nothing is remeshed.
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
    """(P, 3)."""
    normals: Floats
    """(P, 3): on the side of the patch."""
    areas: Floats
    """(P,)."""
    albedo: Floats
    """(P, 3): share of even light that is reflected, at the centre."""
    emitted: Floats
    """(P, 3): power per area that the patch emits."""
    not_diffuse: list[str]
    """Shapes whose material is not diffuse, and is treated as if it were and reflected as much."""
    first_face: Any
    """mi.UInt32 by Mitsuba's number of a shape."""
    first_cell: Any
    """mi.UInt32 by face: the patch of its first cell."""
    cuts: Any
    """mi.UInt32 by face: n."""
    back: Any
    """mi.UInt32 by cell: the patch of its other side, or NOTHING."""
    face: Any
    """mi.UInt32 by patch: the face that it is a part of."""

    def __len__(self) -> int:
        return len(self.areas)

    @cached_property
    def front_normals(self) -> Any:
        """mi.Float: normals of the fronts of all cells, x, y, z in turn."""
        return upload(mi.Float, self.normals[: dr.width(self.back)])

    @property
    def faces(self) -> int:
        """How many faces there are."""
        return int(dr.width(self.cuts))

    @property
    def points(self) -> Points:
        """The centres."""
        return Points(self.centres, self.normals)

    def find(self, ray: Any) -> Any:
        """Return the patch (mi.UInt32) that each ray hits; NOTHING where it misses, or hits a dark side."""
        return self.at(self.scene.ray_intersect_preliminary(ray), ray)

    def at(self, found: Any, ray: Any) -> Any:
        """Return the patch (mi.UInt32) of each hit (mi.PreliminaryIntersection3f) of a ray."""
        hit = found.is_valid()
        cuts = dr.gather(mi.UInt32, self.cuts, self.face_at(found), hit)
        cell = dr.gather(mi.UInt32, self.first_cell, self.face_at(found), hit) + cell_of(found.prim_uv, cuts)
        normal = mi.Vector3f(*(dr.gather(mi.Float, self.front_normals, 3 * cell + k, hit) for k in range(3)))
        side = dr.select(dr.dot(normal, ray.d) < 0, cell, dr.gather(mi.UInt32, self.back, cell, hit))
        return dr.select(hit, side, NOTHING)

    def face_at(self, found: Any) -> Any:
        """Return the face (mi.UInt32) of each hit."""
        shape = dr.reinterpret_array(mi.UInt32, found.shape)
        return dr.gather(mi.UInt32, self.first_face, shape, found.is_valid()) + found.prim_index

    def see(self, radiosity: Floats, surroundings: bool = True) -> See:
        """Return what rays see of a solution (P, 3): the patch, and its radiance; the surroundings where they miss.

        ``surroundings``: whether they shine.
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
    """Return what sees faces instead of patches: how complex a scene is does not hang on how fine it is cut."""

    def seen(ray: Any) -> tuple[Any, Any]:
        patch, radiance = see(ray)
        hit = patch != NOTHING
        return dr.select(hit, dr.gather(mi.UInt32, patches.face, patch, hit), NOTHING), radiance

    return seen


def in_cell(place: Any, cuts: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Return row and column (mi.UInt32) of a cell, the place in it (two mi.Float), and whether it stands on its tip."""
    n, last = mi.Float(cuts), dr.maximum(cuts, 1) - 1
    u, v = dr.clip(place.x, 0, 1) * n, dr.clip(place.y, 0, 1) * n
    i = dr.minimum(mi.UInt32(u), last)
    j = dr.minimum(mi.UInt32(v), last - i)
    u, v = u - mi.Float(i), v - mi.Float(j)
    return i, j, u, v, (u + v > 1) & (i + j < last)


def on_device(rows: Floats) -> list[Any]:
    """Return the channels of rows (P, 3), each an mi.Float."""
    return [upload(mi.Float, channel) for channel in rows.T]


def look_up(channels: list[Any], number: Any) -> Any:
    """Return the rows (mi.Color3f) that ``number`` (mi.UInt32) names; 0 for NOTHING."""
    return mi.Color3f(*(dr.gather(mi.Float, channel, number, number != NOTHING) for channel in channels))


def cell_of(place: Any, cuts: Any) -> Any:
    """Return the cell (mi.UInt32) of barycentric places (mi.Point2f) on faces that are cut n = ``cuts`` times.

    Row i, of n, has 2 (n - i) - 1 cells, which stand on their base and on their tip in turn.
    """
    i, j, _, _, upper = in_cell(place, cuts)
    return i * (2 * cuts - i) + 2 * j + dr.select(upper, mi.UInt32(1), mi.UInt32(0))
