"""Balls and sticks as a scene that stays small and fast for a hundred thousand atoms: two shapes, however many.

All balls are one mesh, and all sticks one shape of straight curves. Mitsuba's ellipsoids would need less memory, but
lose several percent of their area to single precision 200 radii away, and much more at 1000, where the balls of
proteins are; one sphere for each ball would be slow.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.core.sphere import icosphere, normalised

LEVELS = ((3, 500), (2, 12_500), (1, 50_000))
"""Balls are icospheres of these levels, of 20 * 4^level faces, if there are at most so many; of more, of level 0.

In a picture of so many each is a few pixels wide. The time to prepare a scene grows with its faces.
"""


def scene_of(positions: Floats, radii: Floats, bonds: Integers, stick: float) -> Any:
    """Return a scene of balls at ``positions`` (N, 3) with ``radii`` (N,), and of sticks between pairs of balls.

    ``bonds`` (B, 2): numbers of balls; ``stick``: radius of the sticks. The first shape has ``faces_of_ball`` faces for
    each ball, the second, if there are bonds, two for each bond: the half at its first ball, and that at its second.
    """
    shapes = {"balls": balls(positions, radii)}
    if len(bonds):
        shapes["sticks"] = sticks(positions[bonds[:, 0]], positions[bonds[:, 1]], stick)
    return mi.load_dict({"type": "scene", **shapes})


def balls(positions: Floats, radii: Floats) -> Any:
    """Return a mesh of solids that stand for balls; all of them have as many faces, see ``faces_of_ball``."""
    points, faces = solid(len(positions))
    vertices = positions[:, None] + radii[:, None, None] * points
    mesh = mi.Mesh("balls", vertices.size // 3, len(positions) * len(faces), has_vertex_normals=True)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = upload(mi.Float, vertices)
    parameters["vertex_normals"] = upload(mi.Float, np.tile(normalised(points), (len(positions), 1)))
    parameters["faces"] = upload(mi.UInt32, np.arange(len(positions))[:, None, None] * len(points) + faces)
    parameters.update()
    return mesh


def solid(count: int) -> tuple[Floats, Integers]:
    """Return (points, faces) of the solid that stands for a ball of radius 1 in a scene of ``count`` balls.

    Its mean projected area is that of the ball, pi: a quarter of the area of any convex body.
    """
    points, faces = icosphere(next((level for level, most in LEVELS if count <= most), 0))
    a, b, c = points[faces].transpose(1, 0, 2)
    return points * np.sqrt(8 * np.pi / np.linalg.norm(np.cross(b - a, c - a), axis=-1).sum()), faces


def faces_of_ball(count: int) -> int:
    """Return how many faces each ball has in a scene of ``count`` balls."""
    return len(solid(count)[1])


def sticks(begins: Floats, ends: Floats, radius: float) -> Any:
    """Return a shape of round sticks from ``begins`` to ``ends``, (B, 3) each, in two halves of the same length."""
    points = np.stack([begins, (begins + ends) / 2, ends], axis=1).reshape(-1, 3)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "first.txt"  # the shape reads only files, so it begins with any curve of one
        path.write_text("0 0 0 1\n0 0 1 1\n")
        shape = mi.load_dict({"type": "linearcurve", "filename": str(path)})
    parameters = mi.traverse(shape)
    parameters["control_point_count"] = len(points)
    parameters["control_points"] = upload(mi.Float, np.column_stack([points, np.full(len(points), radius)]))
    parameters["segment_indices"] = upload(mi.UInt32, 3 * np.arange(len(begins))[:, None] + np.arange(2))
    parameters.update()
    return shape
