"""An exploring camera on the sphere of viewpoints (the paper, section 4.1.2).

It starts at the best view. Of three smooth ways on, straight ahead or with a turn to either side, it takes the one that
leads to the largest w = v / 2 (1 + d / p), where v is how good the view there is, p the length of the path so far, and
d the distance from the start, so that it does not come back soon. With distances along the sphere, a straight path
keeps w = v, and a path that has come back to the start has w = v / 2.

The paper's text asks for more than its formula: that places already visited are avoided. So w may also be v d / p,
with d the distance from the nearest place that was visited before the last few, and p what it is on a straight path.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tracer.core.arrays import Floats
from tracer.core.sphere import angle, frame, normalised
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.search import Valued

TURN = np.radians(45.0)
"""The camera may turn by this angle in radians to either side at each step."""
Avoided = Literal["start", "visited"]
"""What the camera keeps away from: the start, as in the paper's formula, or all visited places, as in its text."""
RECENT = 3
"""The last places, so many steps back, are near however the camera moves, and so are not counted as visited."""
WIDER = 1.2
"""A loop is at most so many times as far from its start as the circle of the same length is at the same time."""
FIRST_WAYS = 8
"""The first step may go in this many directions, evenly spaced around the start."""


@dataclass(frozen=True)
class Tour:
    """Places of the camera, and how good they are."""

    directions: Floats
    """(N + 1, 3): the directions from the centre to the places; the first is the start."""
    values: Floats
    """(N + 1,): v of each place."""
    weights: Floats
    """(N + 1,): w of each place; v at the start."""

    @property
    def length(self) -> float:
        """Length of the path along the sphere in radians."""
        return float(angle(self.directions[:-1], self.directions[1:]).sum())


def explore(
    value: Valued,
    start: Floats,
    steps: int,
    step: float = np.radians(6.0),
    chord: bool = False,
    avoided: Avoided = "start",
    is_loop: bool = False,
) -> Tour:
    """Return a tour of ``steps`` steps of ``step`` radians from ``start`` (3,).

    ``value`` maps directions (V, 3) to how good their views are (V,), at least 0. ``chord``: distances are measured
    through the sphere, as in the paper's drawing, instead of along it. ``avoided``: what the camera keeps away from.
    ``is_loop``: whether it comes back to the start, on a way that is no more than ``WIDER`` times as wide as a circle.
    """
    places, values = [normalised(start)], [float(value(np.array([start]))[0])]
    weights = [values[0]]
    heading: Floats | None = None
    for k in range(steps):
        here = places[-1]
        ways = ways_on(here, heading)
        if is_loop:
            ways = ways[leads_back(ways, here, places[0], step, steps - k - 1, steps)]
            ways = ways if len(ways) else towards(here, places[0])[None]
        candidates = np.cos(step) * here + np.sin(step) * ways
        candidate_values = value(candidates)
        visited = np.array(places[:1] if avoided == "start" else places[: max(len(places) - RECENT, 1)])
        distances = distances_from(visited, candidates, chord).min(axis=0)
        steps_away = k + 1 if avoided == "start" else min(k, RECENT) + 1
        path = steps_away * (2 * np.sin(step / 2) if chord else step)
        far = np.minimum(distances / path, 1.0)
        candidate_weights = candidate_values * ((1 + far) / 2 if avoided == "start" else far)
        best = int(candidate_weights.argmax())
        # The heading is carried along the great arc.
        heading = np.cos(step) * ways[best] - np.sin(step) * here
        places.append(normalised(candidates[best]))
        values.append(float(candidate_values[best]))
        weights.append(float(candidate_weights[best]))
    if is_loop:
        places[-1] = places[0]
    return Tour(np.array(places), np.array(values), np.array(weights))


def leads_back(ways: Floats, here: Floats, start: Floats, step: float, left: int, steps: int) -> NDArray[np.bool_]:
    """Return which ways (K, 3) stay as near to the start as a loop must, with ``left`` steps after the next one."""
    distances = angle(np.cos(step) * here + np.sin(step) * ways, start)
    circle = step * steps / np.pi * np.sin(np.pi * left / steps)
    return np.asarray(distances <= np.minimum(WIDER * circle, step * left) + 1e-6)


def towards(here: Floats, goal: Floats) -> Floats:
    """Return the unit tangent (3,) of the sphere ``here`` that leads to a goal; any if both are the same."""
    tangent = goal - np.dot(goal, here) * here
    return frame(here)[0] if np.linalg.norm(tangent) < 1e-9 else normalised(tangent)


def distances_from(places: Floats, candidates: Floats, chord: bool) -> Floats:
    """Return the distances (P, C) of candidates (C, 3) from places (P, 3), through the sphere or along it."""
    if chord:
        return np.linalg.norm(candidates[None] - places[:, None], axis=-1)
    return np.asarray(angle(candidates[None], places[:, None]), np.float64)


def ways_on(here: Floats, heading: Floats | None) -> Floats:
    """Return unit tangents (K, 3) of the sphere ``here``: those all round, or with ``heading`` the three ways on."""
    if heading is None:
        turns = np.arange(FIRST_WAYS) * (2 * np.pi / FIRST_WAYS)
        ahead, side = frame(here)
    else:
        turns = np.array([0.0, TURN, -TURN])
        ahead = normalised(heading - np.dot(heading, here) * here)
        side = np.cross(here, ahead)
    return np.cos(turns)[:, None] * ahead + np.sin(turns)[:, None] * side


def smooth(directions: Floats, frames: int, is_loop: bool = False) -> Floats:
    """Return ``frames`` directions (frames, 3) on a smooth curve through ``directions``, evenly spaced in time.

    Those of a loop, whose last direction is the first, end just before it.
    """
    if len(directions) < 2:
        return np.repeat(directions[:1], frames, axis=0)
    knots = np.arange(len(directions))
    curve = CubicSpline(knots, directions, bc_type="periodic" if is_loop else "not-a-knot")
    return normalised(curve(np.linspace(0, knots[-1], frames, endpoint=not is_loop)))


def carried(centre: Floats, distance: float, directions: Floats, up: Floats, is_loop: bool = False) -> Viewpoints:
    """Return viewpoints along a path on which the camera never rolls: each takes over the up of the one before.

    If up were the same everywhere, the camera would spin where it looks nearly along it. Around a loop, up has turned
    when it is back; this turn is undone bit by bit.
    """
    ups = [frame(-directions[0], up)[1]]
    for direction in directions[1:]:
        ups.append(normalised(ups[-1] - np.dot(ups[-1], direction) * direction))
    upward = np.array(ups)
    if is_loop:
        back = normalised(upward[-1] - np.dot(upward[-1], directions[0]) * directions[0])
        turned = np.arctan2(np.dot(np.cross(upward[0], back), directions[0]), np.dot(upward[0], back))
        part = -turned * np.arange(len(ups)) / len(ups)
        across = np.cross(directions, upward)
        upward = np.cos(part)[:, None] * upward + np.sin(part)[:, None] * across
    return Viewpoints(centre + distance * directions, -directions, np.cross(-directions, upward), upward)
