"""Radiosity at the corners of patches, for display: radiosity then changes gradually from a patch to its neighbours.

A corner has the mean radiosity, weighted by area, of the patches of its shape that meet there. Patches meet where the
place and the normal of their corners are the same. The normals are those of the vertices if the shape has any, as it is
then meant to look round, and those of the faces otherwise.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.radiosity.hemisphere import NOTHING
from tracer.radiosity.patches import Patches, in_cell, look_up, on_device
from tracer.radiosity.placed_cells import cells_of_patches, placed_cells

FINENESS = 1 << 20
"""Number of steps along the scene's largest extent to which the places of corners are rounded for comparison."""


class Smooth:
    """Radiosity that is interpolated within patches from their corners."""

    def __init__(self, patches: Patches, radiosity: Floats) -> None:
        corner = corner_numbers(patches)
        count = int(corner.max(initial=-1)) + 1
        weights = np.repeat(patches.areas, 3)
        area = np.bincount(corner.ravel(), weights, count)
        self.patches = patches
        self.corner = upload(mi.UInt32, corner)
        sums = [np.bincount(corner.ravel(), weights * np.repeat(channel, 3), count) for channel in radiosity.T]
        self.values = on_device(np.stack(sums, axis=-1) / (np.pi * area[:, None]))

    def at(self, intersection: Any, ray: Any) -> Any:
        """Return the radiance (mi.Color3f) at each hit (mi.PreliminaryIntersection3f) of a ray; 0 where no patch is."""
        patch = self.patches.at(intersection, ray)
        hit = patch != NOTHING
        cuts = dr.gather(mi.UInt32, self.patches.cuts, self.patches.face_at(intersection), hit)
        weights = corner_weights(intersection.prim_uv, cuts)
        radiance = mi.Color3f(0)
        for k, weight in enumerate(weights):
            corner = dr.gather(mi.UInt32, self.corner, 3 * patch + k, hit)
            radiance += weight * look_up(self.values, dr.select(hit, corner, NOTHING))
        return radiance


def corner_weights(place: Any, cuts: Any) -> tuple[Any, Any, Any]:
    """Return the weight (mi.Float) of each corner of a cell at barycentric places (mi.Point2f) on faces.

    ``cuts`` (mi.UInt32): the number of parts that the edges of the faces are cut into.
    """
    _, _, u, v, upper = in_cell(place, cuts)
    return dr.select(upper, u + v - 1, 1 - u - v), dr.select(upper, 1 - u, u), dr.select(upper, 1 - v, v)


def corner_numbers(patches: Patches) -> Integers:
    """Return the numbers (P, 3) of the corners of all patches; corners that meet have the same number."""
    place, normal, shape_of = placed_cells(patches)
    is_back = np.arange(len(patches)) >= len(place)
    largest_extent = float(np.ptp(place, axis=(0, 1)).max(initial=0)) or 1.0
    grid = np.round((place - place.min(axis=(0, 1))) * (FINENESS / largest_extent))
    # The offset keeps common normals, such as those of boxes, away from the middle between two integers.
    directions = np.round(normal * 20 + 0.21)
    prefix = np.repeat(np.column_stack([shape_of, np.zeros(len(place))])[:, None], 3, axis=1)
    key = np.concatenate([prefix, grid, directions], axis=-1).astype(np.int64)[cells_of_patches(patches)]
    key[is_back, :, 1] = 1
    _, numbers = np.unique(key.reshape(-1, key.shape[-1]), axis=0, return_inverse=True)
    return numbers.reshape(-1, 3)
