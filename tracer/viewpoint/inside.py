"""The best view of a room from inside: all places to stand, all ways to turn, then ever smaller steps from the best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tracer.core.arrays import Floats, Integers, evenly_chosen
from tracer.core.sphere import frame
from tracer.viewpoint import measures
from tracer.viewpoint.direction_measure import SHARE
from tracer.viewpoint.item_buffer import Rays, Viewpoints
from tracer.viewpoint.lens import Perspective
from tracer.viewpoint.room import Room
from tracer.viewpoint.search import REFINED
from tracer.viewpoint.surfaces import Subject
from tracer.viewpoint.survey import better, sum_up, survey

LENS = Perspective(70.0)
"""What is seen inside: 70 degrees across a square image."""
TURNS = 16
"""Number of directions in which a person looks from each place."""
PITCHES = (0.0, -15.0)
"""Degrees above the horizon at which a person looks."""
MOST_PLACES = 200
"""Most places from which views are tried; of more, evenly spread ones."""
COARSE_SIDE = 64
"""Rays along each side of the views that are tried first."""
REFINEMENTS = 5
"""Number of times that the steps around the best views are halved."""


@dataclass(frozen=True)
class Pose:
    """N places of the eye and the directions in which it looks."""

    place: Integers
    """(N,): number of the place in the room."""
    turn: Floats
    """(N,): angle in radians around the upward axis."""
    pitch: Floats
    """(N,): angle in radians above the horizon."""

    def __len__(self) -> int:
        return len(self.place)

    def __getitem__(self, part: slice | Integers) -> Pose:
        return Pose(self.place[part], self.turn[part], self.pitch[part])

    @staticmethod
    def joined(poses: Sequence[Pose]) -> Pose:
        """Return all of these poses, one after the other."""
        columns = zip(*((pose.place, pose.turn, pose.pitch) for pose in poses), strict=True)
        place, turn, pitch = (np.concatenate(column) for column in columns)
        return Pose(place, turn, pitch)


Valued = Callable[[Pose, Rays], Floats]
"""Function from poses to values (N,), of which larger ones are better."""


def viewpoints_of(room: Room, pose: Pose) -> Viewpoints:
    """Return the viewpoints of poses in a room."""
    return looking(room, room.places[pose.place], pose.turn, pose.pitch)


def looking(room: Room, eyes: Floats, turn: Floats, pitch: Floats) -> Viewpoints:
    """Return viewpoints at ``eyes`` (N, 3) that look in directions of these angles (N,), see ``Pose``."""
    right, ahead = frame(room.up)
    level = np.cos(turn)[:, None] * ahead + np.sin(turn)[:, None] * right
    forward = np.cos(pitch)[:, None] * level + np.sin(pitch)[:, None] * room.up
    sideways = np.cross(forward, room.up)
    sideways /= np.linalg.norm(sideways, axis=1, keepdims=True)
    return Viewpoints(eyes, forward, sideways, np.cross(sideways, forward))


def all_poses(room: Room) -> Pose:
    """Return the poses that are tried first."""
    chosen = evenly_chosen(len(room.places), MOST_PLACES)
    place, turn, pitch = np.meshgrid(chosen, np.arange(TURNS) * (2 * np.pi / TURNS), np.radians(PITCHES), indexing="ij")
    return Pose(place.ravel(), turn.ravel(), pitch.ravel())


def value_inside(
    subject: Subject,
    room: Room,
    name: str,
    good: measures.Best,
    background: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> Valued:
    """Return the value of poses by a measure: larger if better, and -inf for a view that sees nothing."""
    needs = measures.get(name).needs
    channel = None
    if "channel" in needs:
        views = viewpoints_of(room, all_poses(room))
        told = (lambda done: progress(done, len(views))) if progress is not None else lambda done: None
        channel = sum_up(subject, views, LENS, Rays(side=COARSE_SIDE), "saliency" in needs, told)

    def value(pose: Pose, rays: Rays) -> Floats:
        values = survey(
            subject,
            viewpoints_of(room, pose),
            LENS,
            rays,
            [name, SHARE],
            background=background,
            channel=channel,
            progress=progress,
        )
        return better(values[name], values[SHARE] > 0, good)

    return value


def best_inside(room: Room, value: Valued, rays: Rays) -> tuple[Pose, Floats, Pose, Floats]:
    """Return the best pose and its value (1,), and the poses that were tried first with their values (N,).

    The best few are refined: steps to the places beside them, and turns, both ways, that are halved time and again.
    """
    poses = all_poses(room)
    values = value(poses, Rays(side=min(COARSE_SIDE, rays.side)))
    best = poses[np.argsort(-values, kind="stable")[:REFINED]]
    best_values = value(best, rays)
    step = np.pi / TURNS
    for _ in range(REFINEMENTS):
        near = [neighbours_of(room, best[k : k + 1], step) for k in range(len(best))]
        candidates = Pose.joined(near)
        owner = np.concatenate([np.arange(len(best)), np.repeat(np.arange(len(best)), [len(pose) for pose in near])])
        tried, tried_values = Pose.joined([best, candidates]), np.append(best_values, value(candidates, rays))
        picks = np.array([np.where(owner == k, tried_values, -np.inf).argmax() for k in range(len(best))])
        best, best_values = tried[picks], tried_values[picks]
        step /= 2
    winner = int(best_values.argmax())
    return best[winner : winner + 1], best_values[winner : winner + 1], poses, values


def neighbours_of(room: Room, pose: Pose, step: float) -> Pose:
    """Return poses near a single one: from the places beside it, and turned or tilted by ``step`` radians."""
    beside = room.beside(int(pose.place[0]))
    place = np.concatenate([beside, np.repeat(pose.place, 4)])
    turn = pose.turn[0] + np.concatenate([np.zeros(len(beside)), [step, -step, 0, 0]])
    pitch = pose.pitch[0] + np.concatenate([np.zeros(len(beside)), [0, 0, step, -step]])
    return Pose(place, turn, np.clip(pitch, -np.pi / 4, np.pi / 4))
