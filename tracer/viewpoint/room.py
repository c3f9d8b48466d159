"""Rooms: scenes that are looked at from inside, from where a person could stand.

From outside, the best view of an interior is that of a closed box. A scene is taken for a room if its own camera is
enclosed by it. A person can stand where there is a floor, almost the full height of the room, and nothing near the eye,
and can walk from one such place to the next if nothing is between them at the height of the eye.
"""

from __future__ import annotations

from dataclasses import dataclass

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.core.sphere import frame, icosphere, normalised
from tracer.viewpoint.surfaces import Subject, box_corners

ACROSS, LEVELS = 40, 6
"""ACROSS: places along the longer side of the floor plan that are tried. LEVELS: heights that are tried, for floors."""
LOOK_LEVEL = 2
"""Directions to look around from a place: the 162 corners of an icosphere of this level."""
ENCLOSED = 0.9
"""A place is inside a room if at least this share of the directions around it hit something."""
EYE_HEIGHT = 0.62
"""Height of the eye above the floor, as a share of the height of the room: 1.6 m of 2.6 m."""
HEADROOM = 0.8
"""A person stands where the room has at least this share of its usual height: not on a table, nor under one."""
CLEARANCE = 0.08
"""Nothing is nearer to the eye than this share of the height of the room: 20 cm of 2.6 m."""


@dataclass(frozen=True)
class Room:
    """Where a person could stand in a room and walk to."""

    places: Floats
    """(P, 3): places of the eye."""
    links: Integers
    """(E, 2): pairs of places between which a person can walk straight."""
    up: Floats
    """(3,): unit vector upwards."""
    height: float
    """Usual height of the room from floor to ceiling."""
    spacing: float
    """Distance of neighbouring places in the floor plan."""

    def beside(self, place: int) -> Integers:
        """Return the numbers of the places next to a place."""
        ends = self.links[np.any(self.links == place, axis=1)]
        return ends[ends != place]


def find_room(subject: Subject, up: Floats, force: bool = False) -> Room | None:
    """Return the room that a scene is; None if it is looked at from outside, or has no place to stand.

    ``force``: whether it is to be looked at from inside in any case.
    """
    upward = normalised(np.asarray(up, np.float64))
    is_inside = has_camera_inside(subject)
    return (
        standing_places(subject, upward, camera_place(subject) if is_inside else None) if is_inside or force else None
    )


def has_camera_inside(subject: Subject) -> bool:
    """Return whether the scene's first camera is enclosed by the scene, as that of a room is."""
    eye = camera_place(subject)
    return eye is not None and bool(is_enclosed(subject, eye[None])[0])


def camera_place(subject: Subject) -> Floats | None:
    """Return the place (3,) of the scene's first camera; None if there is no camera."""
    sensors = subject.scene.sensors()
    if not sensors:
        return None
    return np.array(sensors[0].world_transform().translation(), np.float64).ravel()


def standing_places(subject: Subject, up: Floats, eye: Floats | None) -> Room | None:
    """Return where a person could stand, of all places that are reached from each other, or from ``eye`` (3,)."""
    if np.ptp(box(subject), axis=0).min() == 0:  # something flat
        return None
    columns, spacing = plan(subject, up)
    points = np.concatenate([columns + height * up for height in heights(subject, up)])
    column = np.tile(np.arange(len(columns)), LEVELS)
    inside = is_enclosed(subject, points)
    points, column = points[inside], column[inside]
    if not len(points):
        return None
    below, above = distance_to(subject, points, -up), distance_to(subject, points, up)
    room_height = float(np.quantile(below + above, 0.75))
    tall = (below + above >= HEADROOM * room_height) & (below < np.inf)
    eyes = points[tall] - (below[tall] - EYE_HEIGHT * room_height)[:, None] * up
    column = column[tall]
    # Heights within one room lead to the same eye.
    keys = np.column_stack([column, np.rint(eyes @ up / (0.25 * room_height)).astype(np.int64)])
    eyes = eyes[np.unique(keys, axis=0, return_index=True)[1]]
    if not len(eyes):
        return None
    distances = look_around(subject, eyes)
    free = (distances.min(axis=1) > CLEARANCE * room_height) & (np.isfinite(distances).mean(axis=1) >= ENCLOSED)
    eyes = eyes[free]
    return connected(subject, Room(eyes, np.zeros((0, 2), np.int64), up, room_height, spacing), eye)


def plan(subject: Subject, up: Floats) -> tuple[Floats, float]:
    """Return places (N, 3) of a square grid over the floor plan, at height 0, and their spacing."""
    right, ahead = frame(up)
    corners = box(subject)
    across, along = corners @ right, corners @ ahead
    spacing = max(float(np.ptp(across)), float(np.ptp(along)), 1e-12) / ACROSS
    x, y = (np.arange(side.min() + spacing / 2, side.max(), spacing) for side in (across, along))
    return (x[:, None, None] * right + y[None, :, None] * ahead).reshape(-1, 3), spacing


def heights(subject: Subject, up: Floats) -> Floats:
    """Return the heights (LEVELS,) at which places are tried."""
    levels = box(subject) @ up
    return levels.min() + (np.arange(LEVELS) + 0.5) / LEVELS * np.ptp(levels)


def box(subject: Subject) -> Floats:
    """Return the corners (8, 3) of the bounding box of a scene."""
    return np.stack(np.meshgrid(*box_corners(subject.scene).T, indexing="ij"), axis=-1).reshape(-1, 3)


def look_around(subject: Subject, points: Floats) -> Floats:
    """Return the distances (N, D) from points (N, 3) to what is around them; infinite where nothing is."""
    directions = icosphere(LOOK_LEVEL)[0]
    starts = np.repeat(points, len(directions), axis=0)
    return distance_to(subject, starts, np.tile(directions, (len(points), 1))).reshape(len(points), -1)


def is_enclosed(subject: Subject, points: Floats) -> NDArray[np.bool_]:
    """Return whether the scene is all around points (N, 3)."""
    return np.asarray(np.isfinite(look_around(subject, points)).mean(axis=1) >= ENCLOSED)


def distance_to(subject: Subject, points: Floats, directions: Floats) -> Floats:
    """Return the distances (N,) of what rays from points (N, 3) hit first; infinite for a miss.

    ``directions``: unit, (N, 3) or (3,).
    """
    origins, toward = (
        [upload(mi.Float, column) for column in np.broadcast_to(rows, points.shape).T] for rows in (points, directions)
    )
    hit = subject.scene.ray_intersect_preliminary(mi.Ray3f(mi.Point3f(*origins), mi.Vector3f(*toward)))
    return np.where(np.array(hit.is_valid(), bool), np.array(hit.t, np.float64), np.inf)


def connected(subject: Subject, room: Room, eye: Floats | None) -> Room | None:
    """Return the places of a room that are reached from the one next to ``eye`` (3,), or the most that hang together.

    A person walks to the nearest places in the plan, of about the same height.
    """
    places = room.places
    if not len(places):
        return None
    links = links_between(subject, room)
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(len(places), len(places)))
    label = connected_components(graph, directed=False)[1]
    start = label[np.linalg.norm(places - eye, axis=1).argmin()] if eye is not None else np.bincount(label).argmax()
    kept = np.flatnonzero(label == start)
    number = np.full(len(places), -1)
    number[kept] = np.arange(len(kept))
    return Room(places[kept], number[links[np.isin(links[:, 0], kept)]], room.up, room.height, room.spacing)


def links_between(subject: Subject, room: Room) -> Integers:
    """Return the pairs (E, 2) of neighbouring places with nothing between them."""
    pairs = cKDTree(room.places).query_pairs(1.6 * room.spacing, output_type="ndarray").reshape(-1, 2)
    way = room.places[pairs[:, 1]] - room.places[pairs[:, 0]]
    length = np.linalg.norm(way, axis=1)
    level = np.abs(way @ room.up) < 0.25 * room.height
    pairs, way, length = pairs[level], way[level], length[level]
    if not len(pairs):
        return np.zeros((0, 2), np.int64)
    ahead = distance_to(subject, room.places[pairs[:, 0]], way / length[:, None])
    return np.asarray(pairs[ahead > length + CLEARANCE * room.height], np.int64)
