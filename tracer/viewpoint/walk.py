"""An exploring camera inside a room: it walks from place to place and turns its head, as ``tour`` does on the sphere.

Of the places beside it, and of the directions a little to either side, it takes what leads to the largest
w = v / 2 (1 + d / p), with v how good the view is, p the length of the way so far and d how far the place is from the
start (the paper, section 4.1.2), or to the largest v d / p with d the distance from the nearest place that was visited
before the last few. Lengths are those of the way on foot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from tracer.core.arrays import Floats
from tracer.viewpoint.inside import Pose, Valued, looking
from tracer.viewpoint.item_buffer import Rays, Viewpoints
from tracer.viewpoint.room import CLEARANCE, Room, distance_to
from tracer.viewpoint.surfaces import Subject
from tracer.viewpoint.tour import RECENT, Avoided

HEAD_TURN = np.radians(22.5)
"""The camera may turn by this angle in radians to either side while it walks to the next place."""


@dataclass(frozen=True)
class Walk:
    """Poses of the camera, and how good they are."""

    poses: Pose
    values: Floats
    """(N + 1,): v of each pose."""
    weights: Floats
    """(N + 1,): w of each pose; v at the start."""
    distances: Floats
    """(N + 1,): distance on foot from the start."""


def walk(room: Room, value: Valued, rays: Rays, start: Pose, steps: int, avoided: Avoided = "start") -> Walk:
    """Return a walk of ``steps`` steps from the pose ``start`` (a single one).

    ``value`` tells how good poses are, at least 0. ``avoided``: what the camera keeps away from.
    """
    first = float(value(start, rays)[0])
    poses, values, weights, distances, length = [start], [first], [first], [0.0], 0.0
    lengths = distances_on_foot(room)
    for _ in range(steps):
        here = poses[-1]
        places = room.beside(int(here.place[0]))
        if not len(places):  # the only place of the room: the camera can but turn
            places = here.place
        turns = here.turn[0] + np.array([0.0, HEAD_TURN, -HEAD_TURN])
        place, turn = (grid.ravel() for grid in np.meshgrid(places, turns, indexing="ij"))
        candidates = Pose(place, turn, np.full(len(place), here.pitch[0]))
        candidate_values = value(candidates, rays)
        way = lengths[int(here.place[0]), place]
        passed = [int(pose.place[0]) for pose in poses]
        visited = passed[:1] if avoided == "start" else passed[: max(len(passed) - RECENT, 1)]
        distance = lengths[visited][:, place].min(axis=0)
        path = length + way if avoided == "start" else way * min(len(passed), RECENT + 1)
        far = np.minimum(distance / np.maximum(path, 1e-12), 1.0)
        candidate_weights = candidate_values * ((1 + far) / 2 if avoided == "start" else far)
        best = int(candidate_weights.argmax())
        length += float(way[best])
        poses.append(candidates[best : best + 1])
        values.append(float(candidate_values[best]))
        weights.append(float(candidate_weights[best]))
        distances.append(float(lengths[passed[0], place[best]]))
    return Walk(Pose.joined(poses), np.array(values), np.array(weights), np.array(distances))


def distances_on_foot(room: Room) -> Floats:
    """Return the lengths (P, P) of the shortest ways between places."""
    count = len(room.places)
    first, second = room.links.T
    lengths = np.linalg.norm(room.places[second] - room.places[first], axis=1)
    graph = coo_array((lengths, (first, second)), shape=(count, count))
    return np.asarray(dijkstra(graph.tocsr(), directed=False), np.float64)


def smooth_walk(subject: Subject, room: Room, poses: Pose, count: int) -> Viewpoints:
    """Return the viewpoints of ``count`` frames along a walk.

    Places lie on a smooth curve, unless that would lead through or close to something; then on straight lines.
    """
    knots, frames = np.arange(len(poses)), np.linspace(0, len(poses) - 1, count)
    places = room.places[poses.place]
    curve = CubicSpline(knots, places)(frames)
    if is_blocked(subject, room, curve):
        curve = np.stack([np.interp(frames, knots, column) for column in places.T], axis=-1)
    turns, pitches = (CubicSpline(knots, angles)(frames) for angles in (poses.turn, poses.pitch))
    return looking(room, curve, turns, pitches)


def is_blocked(subject: Subject, room: Room, curve: Floats) -> bool:
    """Return whether something is on a curve (N, 3), or just ahead on it."""
    way = np.diff(curve, axis=0)
    length = np.linalg.norm(way, axis=1)
    moves = length > 1e-9 * room.height
    if not moves.any():
        return False
    ahead = distance_to(subject, curve[:-1][moves], way[moves] / length[moves, None])
    return bool(np.any(ahead < length[moves] + 0.5 * CLEARANCE * room.height))
