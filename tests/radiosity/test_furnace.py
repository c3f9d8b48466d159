"""Furnaces: in a closed box that emits E and reflects rho everywhere, radiosity is E / (1 - rho), however rays go.

Patches that shoot do so from all over their triangles: from their middles, patch i would receive A_j / A_i F_ji of the
radiosity of patch j, which do not add up to 1.
"""

import numpy as np
import pytest
from scipy import stats

from radiosity.scenery import furnace
from tracer.radiosity.gathering import solve
from tracer.radiosity.guide import Guidance
from tracer.radiosity.hemisphere import KINDS
from tracer.radiosity.meshing import cut
from tracer.radiosity.shooting import shoot
from tracer.radiosity.spread import RANDOMLY, chosen_spread

ALBEDO = np.array([0.5, 0.8, 0.2])
SEEDS, RAYS = 8, 192
FALSE_ALARM = 1e-4
"""Chance that any of the comparisons of this file fails although there is nothing wrong."""
ROUNDING = 3e-5
"""Error by single precision, and by ending after a residual."""
THRESHOLDS = {"entropy": 0.3, "gini": 0.1, "distinct": 1.5, "viewpoint_complexity": 0.5, "deviation": 0.1}
# Every group is guided, and nine of ten rays go where the guide sends them: the scene gives no reason to do so.
GUIDES = {kind: Guidance(kind, THRESHOLDS[kind], 1, 16, 0.25, 0.1, 0.0, 0.0) for kind in KINDS}
WAYS = {"evenly": None, "randomly": RANDOMLY, **GUIDES, "paper": chosen_spread("paper_right", "gathering", None, None)}
FAST = ("evenly", "deviation")
METHODS = {
    "gathering": lambda patches, seed, way: solve(patches, RAYS, 1e-7, seed, False, way),
    "gathering with lights": lambda patches, seed, way: solve(patches, RAYS, 1e-7, seed, True, way),
    "shooting": lambda patches, seed, way: shoot(patches, RAYS, 1e-6, seed, way),
}


@pytest.fixture(scope="module")
def patches():
    return cut(furnace(ALBEDO), 1.0)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("way", [way if way in FAST else pytest.param(way, marks=pytest.mark.slow) for way in WAYS])
def test_radiosity_is_as_expected_everywhere(patches, way, method):
    solutions = [METHODS[method](patches, 1000 * seed, WAYS[way]) for seed in range(SEEDS)]
    if way in GUIDES:
        assert min(solution.guided for solution in solutions) > 0.9
    found = np.array([solution.radiosity for solution in solutions]) * (1 - ALBEDO) / np.pi
    deviation = found.std(axis=0, ddof=1)
    # Student, for the mean over seeds of each channel of each patch, shared out to all comparisons (Bonferroni).
    reach = stats.t.isf(FALSE_ALARM / (len(WAYS) * len(METHODS) * deviation.size) / 2, SEEDS - 1)
    assert (np.abs(found.mean(axis=0) - 1) < reach * deviation / np.sqrt(SEEDS) + ROUNDING).all()
    assert np.mean(deviation) < 0.05
    # All patches together tell much smaller errors; those of shooting are exact, as no power is lost but by the paper's
    # rules.
    mean = np.average(found, axis=1, weights=patches.areas)
    is_exact = method == "shooting" and way != "paper"
    reach = 0.0 if is_exact else stats.t.isf(FALSE_ALARM / (3 * len(WAYS) * len(METHODS)) / 2, SEEDS - 1)
    assert (np.abs(mean.mean(axis=0) - 1) < reach * mean.std(axis=0, ddof=1) / np.sqrt(SEEDS) + ROUNDING).all()
