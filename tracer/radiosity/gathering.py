"""The radiosity of all patches, B = E + rho H, from gathering over and over.

The rays of a patch are traced once; what they hit is kept. A round is then B <- E + rho / pi sum w_j B(hit j), for all
patches at once. The sum of what a patch gathers is never more than the whole, so rounds converge as the largest albedo
does. With guidance, a sixteenth of the rays is spread evenly for a rough solution, as many (twice in small groups) look
at it, and the others go where it varies. Those of the rough solution are not used again: the error of a lattice falls
faster than as one over the root of its rays, and a part of few costs more than it brings.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.errors import SceneError, SettingsError
from tracer.progress import StepCallback
from tracer.radiosity.direct import direct_of_patches, silent
from tracer.radiosity.groups import Groups, neighbours
from tracer.radiosity.guide import Guidance, Guide, division_for, make_guide
from tracer.radiosity.hemisphere import MOST_RAYS, NOTHING
from tracer.radiosity.irradiance import hemisphere_rays, passes, sums_of_rays
from tracer.radiosity.lattice import evenly
from tracer.radiosity.patches import Patches, by_face
from tracer.radiosity.warp import warped

Integers = NDArray[np.int64]
MOST_ROUNDS = 1000
HOPE = 50
"""Rounds before it is asked whether they will ever end."""
MOST_TRACED = 1 << 29
"""Rays whose hits are kept: 8 bytes each."""
FIRST = 16
"""One ray of so many finds the rough solution."""
COARSE = 1e-3
"""Residual that is good enough to guide by."""


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
    """Traced, those that looked and those to lights too."""
    guided: float = 0.0
    """Share of the patches whose rays were guided."""


@dataclass(frozen=True)
class Traced:
    """What the rays of all patches found, pass after pass."""

    rays: int
    """Of each patch."""
    order: Integers
    """(P,): patches, pass after pass."""
    hits: list[mi.UInt32]
    weights: list[mi.Float]
    """What each ray stands for, of 1 in all."""
    around: Floats
    """(P, 3): irradiance from the surroundings."""


def solve(
    patches: Patches,
    rays: int = 256,
    residual: float = 1e-5,
    seed: int = 0,
    lights: bool = False,
    guidance: Guidance | None = None,
    told: StepCallback = silent,
) -> Solution:
    """Return the solution with ``rays`` rays a patch, gathered until a round changes less than ``residual``.

    ``lights``: light straight from emitters comes from as many places on these, instead of from rays that hit them.
    ``guidance``: how to guide rays; all are spread evenly without. Raises SettingsError for too many rays to keep.
    """
    refuse_too_many(rays, len(patches))
    direct = direct_of_patches(patches, rays, seed, told) if lights else np.zeros((len(patches), 3))
    groups = neighbours(patches.points, guidance.members if guidance else MOST_RAYS)
    division = division_for(guidance, rays) if guidance else None
    spent = rays if lights else 0
    if guidance is None or division is None:
        traced = trace(patches, groups, rays, seed, not lights, told)
        return finish(patches, traced, direct, residual, lights, spent, 0.0, told)
    first = trace(patches, groups, max(rays // FIRST, 1), seed, not lights, told)
    known = finish(patches, first, direct, max(residual, COARSE), lights, 0, 0.0, told)
    see = patches.see(known.radiosity - patches.emitted if lights else known.radiosity, surroundings=not lights)
    guide = make_guide(by_face(patches, see), groups, division, guidance, patches.faces, seed + 1)
    looked = -(-guide.regions.rays // len(patches))
    spent += looked + first.rays
    second = trace(patches, groups, max(rays - first.rays - looked, 1), seed + 2, not lights, told, guide)
    return finish(patches, second, direct, residual, lights, spent, float(guide.guided.mean()), told)


def refuse_too_many(rays: int, patches: int) -> None:
    """Raise SettingsError for more rays than there is room for."""
    if rays * patches > MOST_TRACED:
        raise SettingsError(
            f"{rays} rays of each of {patches} patches are more than {MOST_TRACED}, which is too many; "
            "allow longer edges of patches, or fewer rays."
        )


def trace(
    patches: Patches,
    groups: Groups,
    rays: int,
    seed: int,
    surroundings: bool,
    told: StepCallback,
    guide: Guide | None = None,
) -> Traced:
    """Trace ``rays`` rays of every patch, evenly or where a guide says."""
    order, hits, weights, around = [], [], [], np.zeros((len(patches), 3))
    dark = patches.see(np.zeros((len(patches), 3)), surroundings)
    way, guided = (warped(guide), guide.guided) if guide else (evenly, None)
    done = 0
    for some, how in passes(len(patches), rays, way, guided):
        told("rays", done, len(patches))
        ray, weight = hemisphere_rays(groups, some, rays, how, seed)
        patch, radiance = dark(ray)
        arriving = [channel * weight for channel in radiance]
        weight /= dr.pi
        dr.eval(patch, weight, arriving)
        order.append(some)
        hits.append(patch)
        weights.append(weight)
        around[some] = sums_of_rays(arriving, rays)
        done += len(some)
    return Traced(rays, np.concatenate(order), hits, weights, around)


def finish(
    patches: Patches,
    traced: Traced,
    direct: Floats,
    residual: float,
    lights: bool,
    spent: int,
    guided: float,
    told: StepCallback,
) -> Solution:
    """Return the solution along rays that are traced."""
    arriving = direct + traced.around
    supplied = float(np.sum(patches.areas[:, None] * (patches.emitted + patches.albedo * arriving)))
    radiosity, irradiance = patches.emitted, arriving
    change, done = np.inf, 0
    while change > residual and done < MOST_ROUNDS:
        irradiance = arriving + gathered(traced, radiosity - patches.emitted if lights else radiosity)
        following = patches.emitted + patches.albedo * irradiance
        moved = float(np.sum(patches.areas[:, None] * np.abs(following - radiosity))) / max(supplied, 1e-300)
        if done >= HOPE and moved > COARSE and rounds_left(moved, moved / change, residual) > MOST_ROUNDS:
            raise SceneError(
                f"Light goes to and fro for ever: a round does {100 * moved / change:.2f} % of the one before. "
                f"The largest albedo is {patches.albedo.max():.4g}; make it less than 1, or let some light out."
            )
        change, radiosity, done = moved, following, done + 1
        told(f"round {done}: {change:.1e} of the power moved", min(done, MOST_ROUNDS - 1), MOST_ROUNDS)
    return Solution(radiosity, irradiance, change, done, (traced.rays + spent) * len(patches), guided)


def rounds_left(change: float, ratio: float, residual: float) -> float:
    """Return how many more rounds it takes if each changes ``ratio`` of what the one before did."""
    if change <= residual:
        return 0.0
    return float(np.log(residual / change) / np.log(ratio)) if ratio < 1 else np.inf


def gathered(traced: Traced, radiosity: Floats) -> Floats:
    """Return the mean radiosity (P, 3) of what the rays of each patch hit, each by what it stands for."""
    found = np.zeros_like(radiosity)
    for channel, values in enumerate(radiosity.T):
        table = upload(mi.Float, values)
        sums = [
            sums_of_rays([dr.gather(mi.Float, table, hit, hit != NOTHING) * weight], traced.rays)[:, 0]
            for hit, weight in zip(traced.hits, traced.weights, strict=True)
        ]
        found[traced.order, channel] = np.concatenate(sums)
    return found
