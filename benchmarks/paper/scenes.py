"""Rooms of thousands of patches, with simple walls and a corner full of small things, as in the paper."""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np

from benchmarks.radiosity.scenes import Example, camera, grey, load, rgb, scattered

CORNER, REACH = (3.2, 3.2, 1.4), 1.2
"""Middle of the small things, and how far they are from it at most along each axis."""
THINGS, SIDE = 250, 0.05
"""Number of the small things, and half the edge of each."""
EDGE = 0.5
"""Longest edge of a patch."""


def rooms() -> list[Example]:
    """Return the rooms. Whether what is complex is also bright is what tells them apart."""
    return [
        Example("clutter", "small grey things in a corner, under a lamp", load(room(lamp=True)), EDGE, True),
        Example("shining clutter", "small things in a corner are the lamps", load(room(shining=1.0)), EDGE, True),
        Example("lamps in clutter", "a tenth of the small things are lamps", load(room(shining=0.1)), EDGE, True),
        Example("clutter, reflected", "light that walls and things reflect alone", load(room(lamp=True)), EDGE, False),
    ]


def room(shining: float = 0.0, lamp: bool = False) -> dict[str, Any]:
    """Return a room with small things in a corner; ``shining``: the share of them that are lamps."""
    transform = mi.ScalarTransform4f
    parts: dict[str, Any] = {
        "type": "scene",
        "sensor": camera([-4.5, -4.5, 3.5], [2.0, 2.0, 1.2]),
        "hall": {
            "type": "cube",
            "flip_normals": True,
            "to_world": transform().translate([0, 0, 2.5]).scale([5, 5, 2.5]),
            "bsdf": grey(0.55),
        },
    }
    if lamp:
        hung = transform().translate([-1, -1, 4.9]).rotate([1, 0, 0], 180).scale(1)
        parts["lamp"] = {"type": "rectangle", "to_world": hung, "emitter": {"type": "area", "radiance": rgb([10] * 3)}}
    is_lamp = np.random.default_rng(2).random(THINGS) < shining
    for index, place in enumerate(scattered(THINGS, list(CORNER), REACH, SIDE, 1)):
        shade = 0.2 + 0.6 * (index % 7) / 6
        light = {"emitter": {"type": "area", "radiance": rgb([2 / shining] * 3)}} if is_lamp[index] else {}
        parts[f"thing_{index:03}"] = {"type": "cube", "to_world": place, "bsdf": grey(shade), **light}
    return parts


def in_corner(centres: np.ndarray) -> np.ndarray:
    """Return which of the centres (N, 3) of patches are among the small things or near them."""
    return np.asarray(np.all(np.abs(centres - np.array(CORNER)) < REACH + 0.5, axis=1))
