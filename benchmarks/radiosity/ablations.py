"""Which kind of complexity guides best, what share of the rays it should guide, and how deep hemispheres are divided.

All groups are guided here, whether a gain is expected or not, but for the last of ``USES``.
"""

from __future__ import annotations

from dataclasses import astuple, replace
from typing import Any

import numpy as np

from benchmarks.harness import Announce, ratio_over_seeds
from benchmarks.radiosity.convergence import Place, guided
from tracer.radiosity.guide import Guidance, division_for
from tracer.radiosity.irradiance import gather
from tracer.radiosity.lattice import evenly

RAYS = 256
"""Rays a point."""
SEEDS = 3
"""Number of seeds."""
USUAL = Guidance(worth=0.0, overall=0.0)
"""Guidance with the usual parameters that guides all groups."""
USES = {
    "deviation": USUAL,
    "distinct": replace(USUAL, kind="distinct", threshold=4.0),
    "entropy": replace(USUAL, kind="entropy", threshold=1.0),
    "gini": replace(USUAL, kind="gini", threshold=0.4),
    "viewpoint_complexity": replace(USUAL, kind="viewpoint_complexity", threshold=1.0),
    **{f"deviation, floor {floor:g}": replace(USUAL, floor=floor) for floor in (0.1, 0.3, 0.7)},
    **{f"deviation, depth {depth}": replace(USUAL, depth=depth) for depth in (0, 1, 3)},
    **{f"deviation, looks 1/{part}": replace(USUAL, look=1 / part) for part in (32, 8)},
    "deviation, where it is worth it": Guidance(),
}
"""Guidance of each use of complexity, by its name."""


def step_count() -> int:
    """Return the number of steps of a scene."""
    return len(USES)


def uses(place: Place, announce: Announce) -> list[dict[str, Any]]:
    """Return the gain of every use of complexity over as many evenly spread rays."""

    def error(irradiance: Any) -> float:
        return float(np.mean((irradiance - place.truth) ** 2))

    even = [error(gather(place.see, place.single, RAYS, evenly, seed).irradiance) for seed in range(SEEDS)]
    rows = []
    for name, guidance in USES.items():
        announce(f"{place.example.name}, {name}")
        division = division_for(guidance, RAYS)
        assert division is not None
        results = [guided(place, place.groups, division, guidance, RAYS, seed) for seed in range(SEEDS)]
        errors = [error(result.irradiance) for result in results if result is not None]
        if len(errors) == SEEDS:
            gain = astuple(ratio_over_seeds(errors, even))
            rows.append({"scene": place.example.name, "use": name, "equal_rays": gain})
    return rows
