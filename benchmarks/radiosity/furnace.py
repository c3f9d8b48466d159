"""A furnace, in which the radiosity of every patch is known: how far patches are off with each way to send rays.

In a closed box that emits E and reflects rho everywhere, radiosity is E / (1 - rho).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mitsuba as mi
import numpy as np

from benchmarks.harness import Announce
from tracer.radiosity.gathering import solve
from tracer.radiosity.meshing import cut
from tracer.radiosity.patches import Patches
from tracer.radiosity.shooting import shoot
from tracer.radiosity.spread import SPREADS

ALBEDO = (0.5, 0.8, 0.2)
"""Albedo of each channel."""
EDGE = 1.0
"""Longest edge of a patch; that of the box is 2."""
RAYS = (256, 4096)
"""Numbers of rays a patch."""
WAYS: dict[str, tuple[Callable[..., Any], str]] = {
    "gathering, evenly": (solve, "evenly"),
    "gathering, guided": (solve, "guided"),
    "shooting, evenly": (shoot, "evenly"),
    "shooting, randomly": (shoot, "randomly"),
    "shooting, paper": (shoot, "paper"),
    "shooting, paper_right": (shoot, "paper_right"),
}
"""Solver and spread of rays of each way."""


def step_count() -> int:
    """Return the number of steps."""
    return len(WAYS)


def furnace(announce: Announce) -> list[dict[str, Any]]:
    """Return how far patches are off for each way and number of rays, as shares of what they should be."""
    patches = box()
    rows = []
    for name, (solver, spread) in WAYS.items():
        announce(f"furnace, {name}")
        for rays in RAYS:
            solution = solver(patches, rays, 1e-6, spread=SPREADS[spread])
            off = solution.radiosity * (1 - np.array(ALBEDO)) / np.pi - 1
            rows.append(
                {
                    "way": name,
                    "rays": rays,
                    "patches": len(patches),
                    "mean": float(np.abs(off).mean()),
                    "most": float(np.abs(off).max()),
                    "all": float(np.average(off.mean(axis=1), weights=patches.areas)),
                }
            )
    return rows


def box() -> Patches:
    """Return the patches of the furnace, whose radiance is 1."""
    bsdf = {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(ALBEDO)}}
    emitter = {"type": "area", "radiance": 1.0}
    walls = {"type": "cube", "flip_normals": True, "bsdf": bsdf, "emitter": emitter}
    return cut(mi.load_dict({"type": "scene", "walls": walls}), EDGE)
