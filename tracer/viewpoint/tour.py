"""An exploring camera on the sphere of viewpoints (the paper, section 4.1.2).

It starts at the best view. Of three smooth ways on, straight and a turn to either side, it takes the one to the place
of the largest w = v / 2 (1 + d / p): v is how good the view is, p the path so far and d the distance from the start, so
that it does not come back soon. Where distances are those on the sphere, a straight way keeps w = v, and one that has
come back halves it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from tracer.core.arrays import Floats
from tracer.core.sphere import angle, frame, normalised
from tracer.viewpoint.item_buffer import Viewpoints
from tracer.viewpoint.search import Valued

TURN = np.radians(45.0)
"""Between the three ways on."""
FIRST_WAYS = 8
"""Ways in which it may start."""


@dataclass(frozen=True)
class Tour:
    """Places of the camera, and how good they are."""

    directions: Floats
    """(N + 1, 3), the first is the start."""
    values: Floats
    """(N + 1,): v of each."""
    weights: Floats
    """(N + 1,): w of each; of the start v."""

    @property
    def length(self) -> float:
        """Path in radians."""
        return float(angle(self.directions[:-1], self.directions[1:]).sum())


def explore(value: Valued, start: Floats, steps: int, step: float = np.radians(6.0), chord: bool = False) -> Tour:
    """Return a tour of ``steps`` steps of ``step`` radians from ``start`` (3,).

    ``value`` maps directions (V, 3) to goodness >= 0. ``chord``: distance from the start through the sphere, as in the
    paper's drawing, instead of on it.
    """
    places, values = [normalised(start)], [float(value(np.array([start]))[0])]
    weights = [values[0]]
    heading: Floats | None = None
    for k in range(steps):
        here = places[-1]
        ways = ways_on(here, heading)
        there = np.cos(step) * here + np.sin(step) * ways
        found = value(there)
        far = np.linalg.norm(there - places[0], axis=-1) if chord else angle(there, places[0])
        path = (k + 1) * (2 * np.sin(step / 2) if chord else step)
        worth = found / 2 * (1 + np.minimum(far / path, 1.0))
        best = int(worth.argmax())
        # The heading is carried along the great arc.
        heading = np.cos(step) * ways[best] - np.sin(step) * here
        places.append(normalised(there[best]))
        values.append(float(found[best]))
        weights.append(float(worth[best]))
    return Tour(np.array(places), np.array(values), np.array(weights))


def ways_on(here: Floats, heading: Floats | None) -> Floats:
    """Return the directions (K, 3) of movement, unit and tangent to the sphere: all round, or on from ``heading``."""
    if heading is None:
        turns = np.arange(FIRST_WAYS) * (2 * np.pi / FIRST_WAYS)
        ahead, side = frame(here)
    else:
        turns = np.array([0.0, TURN, -TURN])
        ahead = normalised(heading - np.dot(heading, here) * here)
        side = np.cross(here, ahead)
    return np.cos(turns)[:, None] * ahead + np.sin(turns)[:, None] * side


def smooth(directions: Floats, frames: int) -> Floats:
    """Return ``frames`` directions (frames, 3) on a smooth curve through ``directions``, evenly spaced in time."""
    if len(directions) < 2:
        return np.repeat(directions[:1], frames, axis=0)
    knots = np.arange(len(directions))
    return normalised(CubicSpline(knots, directions)(np.linspace(0, knots[-1], frames)))


def carried(centre: Floats, distance: float, directions: Floats, up: Floats) -> Viewpoints:
    """Return viewpoints along a path whose camera never rolls: its up is carried on from place to place.

    An up that is the same everywhere would spin the camera about where it looks along it.
    """
    ups = [frame(-directions[0], up)[1]]
    for direction in directions[1:]:
        ups.append(normalised(ups[-1] - np.dot(ups[-1], direction) * direction))
    upward = np.array(ups)
    return Viewpoints(centre + distance * directions, -directions, np.cross(-directions, upward), upward)
