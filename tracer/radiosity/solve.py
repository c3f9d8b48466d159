"""The radiosity of all patches, B = E + rho H, from gathering over and over.

The rays of a patch are traced once; what they hit is kept. A round is then B <- E + rho / n sum B(hit), for all patches
at once. The sum of what a patch gathers is never more than the whole, so rounds converge as the largest albedo does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.radiosity.direct import direct_of_patches
from tracer.radiosity.gather import hemisphere_rays
from tracer.radiosity.groups import alone
from tracer.radiosity.hemisphere import MOST_RAYS, NOTHING
from tracer.radiosity.lattice import evenly
from tracer.radiosity.patches import Patches

Floats = NDArray[np.float64]
MOST_ROUNDS = 1000
Told = Callable[[str, int, int], None]
"""Called with what is under way, how much of it is done, and how much there is. May raise to stop."""


@dataclass(frozen=True)
class Solution:
    """Radiosity of patches."""

    radiosity: Floats
    """(P, 3): power per area that leaves each patch."""
    irradiance: Floats
    """(P, 3): power per area that arrives."""
    residual: float
    """Power that the last round changed, as a share of all that is emitted and arrives from around."""
    rounds: int
    rays: int


def solve(
    patches: Patches,
    rays: int = 256,
    residual: float = 1e-5,
    seed: int = 0,
    lights: bool = False,
    told: Told = lambda text, done, total: None,
) -> Solution:
    """Return the solution with ``rays`` rays a patch, gathered until a round changes less than ``residual``.

    ``lights``: light straight from emitters comes from as many places on these, instead of from rays that hit them.
    """
    hits, around = [], []
    groups = alone(patches.points)
    dark = patches.see(np.zeros((len(patches), 3)), surroundings=not lights)
    most = max(1, MOST_RAYS // rays)
    for first in range(0, len(patches), most):
        told("rays", first, len(patches))
        ray, _ = hemisphere_rays(groups, first, min(most, len(patches) - first), rays, evenly, seed)
        patch, radiance = dark(ray)
        sums = [dr.block_sum(channel, rays) * (np.pi / rays) for channel in radiance]
        dr.eval(patch, sums)
        hits.append(patch)
        around.append(np.stack([one.numpy() for one in sums], axis=-1))
    from_around = np.concatenate(around).astype(np.float64)
    if lights:
        told("lights", 0, 1)
        from_around += direct_of_patches(patches, rays, seed)
    supplied = float(np.sum(patches.areas[:, None] * (patches.emitted + patches.albedo * from_around)))
    radiosity, irradiance = patches.emitted, from_around
    change, done = np.inf, 0
    while change > residual and done < MOST_ROUNDS:
        irradiance = from_around + gathered(hits, radiosity - patches.emitted if lights else radiosity, rays)
        following = patches.emitted + patches.albedo * irradiance
        moved = float(np.sum(patches.areas[:, None] * np.abs(following - radiosity)))
        change, radiosity, done = moved / max(supplied, 1e-300), following, done + 1
        told(f"round {done}: {change:.1e} of the power moved", min(done, MOST_ROUNDS - 1), MOST_ROUNDS)
    return Solution(radiosity, irradiance, change, done, rays * len(patches))


def gathered(hits: list[mi.UInt32], radiosity: Floats, rays: int) -> Floats:
    """Return the mean radiosity (P, 3) of what the rays of each patch hit."""
    channels = []
    for values in radiosity.T:
        table = mi.Float(values.astype(np.float32))
        sums = [dr.block_sum(dr.gather(mi.Float, table, hit, hit != NOTHING), rays).numpy() for hit in hits]
        channels.append(np.concatenate(sums).astype(np.float64) / rays)
    return np.stack(channels, axis=-1)
