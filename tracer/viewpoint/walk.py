"""An exploring camera inside a room: it walks from place to place and turns its head, as ``tour`` does on the sphere.

Of the places beside it, and of all directions around, it takes what leads to the largest w = v / 2 (1 + d / p), with v
how good the view is, p the length of the way so far and d how far the place is from the start (the paper, section
4.1.2), or to the largest v d / p with d the distance from the nearest place that was visited before the last few.
Lengths are those of the way on foot. Here v is the value of the view by a measure, times the share of what is new in
it, and less for directions that it takes long to turn to. The camera turns there bit by bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from tracer.core.arrays import Floats
from tracer.viewpoint.inside import COARSE_SIDE, Pose, Valued, looking
from tracer.viewpoint.item_buffer import Rays, Viewpoints
from tracer.viewpoint.novelty import Memory
from tracer.viewpoint.room import CLEARANCE, Room, distance_to
from tracer.viewpoint.surfaces import Subject
from tracer.viewpoint.tour import RECENT, Avoided

HEAD_TURN = np.radians(10.0)
"""The camera turns by at most this angle in radians while it walks to the next place.

With the defaults of a film, whose steps take three frames each, this is 83 degrees in a second.
"""
ROUND = 16
"""From each place, views in this many directions all round are compared."""
SEEN_COUNTS = 0.1
"""What was seen already counts by this share of what is new, so that the camera looks well when all has been seen."""


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


def walk(
    room: Room,
    value: Valued,
    rays: Rays,
    start: Pose,
    steps: int,
    avoided: Avoided = "start",
    memory: Memory | None = None,
    is_loop: bool = False,
) -> Walk:
    """Return a walk of ``steps`` steps from the pose ``start`` (a single one).

    ``value`` tells how good poses are, at least 0. ``avoided``: what the camera keeps away from. ``memory``: what it
    has seen, nothing to begin with; without one, what is new does not count. ``is_loop``: whether it ends as it starts.
    """
    first = float(value(start, rays)[0])
    poses, values, weights, distances, length = [start], [first], [first], [0.0], 0.0
    lengths, hops = distances_on_foot(room), steps_on_foot(room)
    coarse = rays if rays.random else Rays(side=min(rays.side, COARSE_SIDE))
    for left in range(steps - 1, -1, -1):
        here = poses[-1]
        if memory is not None:
            memory.remember(here)
        around = all_round(room, here, left if is_loop else None, hops[int(start.place[0])])
        place = around.place
        worth = value(around, coarse)
        if memory is not None:
            worth = worth * (SEEN_COUNTS + memory.new_share(around)) / (SEEN_COUNTS + 1)
        turn_away = np.abs(wrapped(around.turn - here.turn[0])) / np.pi
        worth = worth / 2 * (2 - turn_away)
        way = lengths[int(here.place[0]), place]
        passed = [int(pose.place[0]) for pose in poses]
        visited = passed[:1] if avoided == "start" else passed[: max(len(passed) - RECENT, 1)]
        distance = lengths[visited][:, place].min(axis=0)
        path = length + way if avoided == "start" else way * min(len(passed), RECENT + 1)
        far = np.minimum(distance / np.maximum(path, 1e-12), 1.0)
        candidate_weights = worth * ((1 + far) / 2 if avoided == "start" else far)
        best = int(candidate_weights.argmax())
        length += float(way[best])
        change = float(np.clip(wrapped(around.turn[best] - here.turn[0]), -HEAD_TURN, HEAD_TURN))
        turn = here.turn + (turn_back(here, start, change, left) if is_loop else change)
        poses.append(Pose(place[best : best + 1], turn, here.pitch))
        values.append(float(value(poses[-1], rays)[0]))
        weights.append(float(candidate_weights[best]))
        distances.append(float(lengths[passed[0], place[best]]))
    return Walk(Pose.joined(poses), np.array(values), np.array(weights), np.array(distances))


def all_round(room: Room, here: Pose, left: int | None, hops: Floats) -> Pose:
    """Return the views all round from the places beside a pose, the first of each in the direction of the pose.

    ``left``: number of steps after this one within which the way back has to be possible, None if it need not be.
    ``hops`` (P,): number of steps back from each place.
    """
    places = room.beside(int(here.place[0]))
    if left is not None:
        places = places[hops[places] <= left]
    if not len(places):  # the only place of the room, or a step too many for the way back: the camera can but turn
        places = here.place
    turns = here.turn[0] + np.arange(ROUND) * (2 * np.pi / ROUND)
    place, turn = (grid.ravel() for grid in np.meshgrid(places, turns, indexing="ij"))
    return Pose(place, turn, np.full(len(place), here.pitch[0]))


def turn_back(here: Pose, start: Pose, change: float, left: int) -> float:
    """Return ``change`` radians, or the turn towards the first direction if that would else be too far away."""
    offset = float(wrapped(here.turn - start.turn)[0])
    if abs(float(wrapped(offset + change))) <= left * HEAD_TURN + 1e-9:
        return change
    return float(np.clip(-offset, -HEAD_TURN, HEAD_TURN))


def wrapped(angles: Any) -> Floats:
    """Return angles in radians, less whole turns: from -pi to pi."""
    return np.asarray((np.asarray(angles, np.float64) + np.pi) % (2 * np.pi) - np.pi)


def distances_on_foot(room: Room) -> Floats:
    """Return the lengths (P, P) of the shortest ways between places."""
    return shortest_ways(room, is_counted=False)


def steps_on_foot(room: Room) -> Floats:
    """Return the least numbers (P, P) of steps between places."""
    return shortest_ways(room, is_counted=True)


def shortest_ways(room: Room, is_counted: bool) -> Floats:
    """Return the lengths (P, P) of the shortest ways between places; ``is_counted``: every link has the length 1."""
    count = len(room.places)
    first, second = room.links.T
    lengths = np.linalg.norm(room.places[second] - room.places[first], axis=1)
    graph = coo_array((lengths, (first, second)), shape=(count, count))
    return np.asarray(dijkstra(graph.tocsr(), directed=False, unweighted=is_counted), np.float64)


def smooth_walk(subject: Subject, room: Room, poses: Pose, count: int, is_loop: bool = False) -> Viewpoints:
    """Return the viewpoints of ``count`` frames along a walk; those of a loop end just before its start.

    Places lie on a smooth curve, unless that would lead through or close to something; then on straight lines.
    """
    knots, frames = np.arange(len(poses)), np.linspace(0, len(poses) - 1, count, endpoint=not is_loop)
    places = room.places[poses.place]
    if is_loop:
        places = np.concatenate([places[:-1], places[:1]])
    curve = CubicSpline(knots, places, bc_type="periodic" if is_loop else "not-a-knot")(frames)
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
