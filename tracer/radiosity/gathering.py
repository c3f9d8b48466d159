"""The radiosity of all patches, B = E + rho H, from gathering over and over.

The rays of a patch are traced once, and their hits are stored. A round is then B <- E + rho / pi sum w_j B(hit j), for
all patches at once. The weights w_j of a patch add up to pi, so a round multiplies the change by no more than the
largest albedo; only by the paper's rules they may add up to more.

With guidance, a sixteenth of the rays is spread evenly for a rough solution, as many rays (twice as many in small
groups) look at it, and the others are sent where it varies. The rays of the rough solution are not used again: the
error of a lattice falls faster than as one over the root of its rays, so a separate lattice of few rays costs more
accuracy than it adds.
"""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import upload
from tracer.errors import SceneError, SettingsError
from tracer.progress import StepCallback
from tracer.radiosity.direct import direct_of_patches, silent
from tracer.radiosity.groups import Groups, alone, neighbours
from tracer.radiosity.guide import Guidance, division_for, make_guide
from tracer.radiosity.hemisphere import MOST_RAYS, NOTHING
from tracer.radiosity.irradiance import Chosen, hemisphere_rays, passes, sums_of_rays
from tracer.radiosity.lattice import Way, evenly, randomly
from tracer.radiosity.paper import PaperRays, PaperRules, paper_guide
from tracer.radiosity.patches import Patches, by_face
from tracer.radiosity.spread import RANDOMLY, Spread
from tracer.radiosity.warp import warped

MOST_ROUNDS = 1000
"""Largest number of rounds of a solution."""
HOPE = 50
"""Number of rounds after which a solution is checked for whether it will ever converge."""
MOST_TRACED = 1 << 29
"""Largest number of rays whose hits are stored, at 8 bytes a ray."""
FIRST = 16
"""One ray in this many goes into the rough solution."""
COARSE = 1e-3
"""Residual at which a rough solution is good enough to guide rays by."""


@dataclass(frozen=True)
class Solution:
    """Radiosity of patches."""

    radiosity: Floats
    """(P, 3): power per area that leaves each patch."""
    irradiance: Floats
    """(P, 3): power per area that arrives."""
    residual: float
    """Power that the last round changed, as a share of all power that is emitted or arrives from the surroundings."""
    rounds: int
    rays: int
    """Number of rays traced, including those that looked and those to lights."""
    guided: float = 0.0
    """Share of the patches whose rays were guided."""
    energy: float = 1.0
    """Mean over patches of the sum of the weights of their rays: 1 if energy is conserved."""


@dataclass(frozen=True)
class Traced:
    """What the rays of all patches hit, pass after pass."""

    rays: int
    """Number of rays of each patch."""
    order: Integers
    """(P,): patches in the order in which their rays were traced."""
    hits: list[mi.UInt32]
    """For each pass, the patch that each ray hits; NOTHING where it hits none."""
    weights: list[mi.Float]
    """For each pass, the weight of each ray; the weights of a patch add up to 1, or about 1 by the paper's rules."""
    around: Floats
    """(P, 3): irradiance from the surroundings."""


def solve(
    patches: Patches,
    rays: int = 256,
    residual: float = 1e-5,
    seed: int = 0,
    lights: bool = False,
    spread: Spread = None,
    on_step: StepCallback = silent,
) -> Solution:
    """Return the solution with ``rays`` rays a patch, gathered until a round changes no more than ``residual``.

    ``lights``: light straight from emitters comes from as many places on the emitters, instead of from rays that hit
    them. ``spread``: how rays are spread over hemispheres; the same number of rays includes those that look. Raises
    SettingsError for more rays than can be stored, and SceneError if the rounds do not converge.
    """
    refuse_too_many(rays, len(patches))
    direct = direct_of_patches(patches, rays, seed, on_step) if lights else np.zeros((len(patches), 3))
    extra_rays = rays if lights else 0
    if isinstance(spread, PaperRules):
        way, look_rays, guided = paper_way(patches, spread, rays, seed)
        traced = trace(patches, alone(patches.points), rays - look_rays, seed, not lights, on_step, way)
        return finish(patches, traced, direct, residual, lights, extra_rays + look_rays, guided, on_step)
    guidance = spread if isinstance(spread, Guidance) else None
    groups = neighbours(patches.points, guidance.members if guidance else MOST_RAYS)
    division = division_for(guidance, rays) if guidance else None
    if guidance is None or division is None:
        even_way = randomly if spread == RANDOMLY else evenly
        traced = trace(patches, groups, rays, seed, not lights, on_step, even_way)
        return finish(patches, traced, direct, residual, lights, extra_rays, 0.0, on_step)
    rough_traced = trace(patches, groups, max(rays // FIRST, 1), seed, not lights, on_step)
    rough = finish(patches, rough_traced, direct, max(residual, COARSE), lights, 0, 0.0, on_step)
    on_step("looks", 0, len(patches))
    see = patches.see(rough.radiosity - patches.emitted if lights else rough.radiosity, surroundings=not lights)
    guide = make_guide(by_face(patches, see), groups, division, guidance, patches.faces, seed + 1)
    look_rays = -(-guide.regions.rays // len(patches))
    extra_rays += look_rays + rough_traced.rays
    guided_traced = trace(
        patches,
        groups,
        max(rays - rough_traced.rays - look_rays, 1),
        seed + 2,
        not lights,
        on_step,
        warped(guide),
        guide.guided,
    )
    return finish(patches, guided_traced, direct, residual, lights, extra_rays, float(guide.guided.mean()), on_step)


def paper_way(patches: Patches, rules: PaperRules, rays: int, seed: int) -> tuple[Way, int, float]:
    """Return rays by the paper's rules, the rays of each patch that looked for it, and the share of guided patches.

    Rays look at patches only, because no radiosity is known yet. Raises SettingsError if looks take all ``rays``.
    """
    see = by_face(patches, patches.see(np.zeros((len(patches), 3)), surroundings=False))
    guide = paper_guide(see, alone(patches.points), rules, patches.faces, seed + 1)
    look_rays = -(-guide.regions.rays // len(patches))
    if look_rays >= rays:
        raise SettingsError(
            f"By the paper's rules {look_rays} rays of each patch look, and there are {rays}; give more rays, or let "
            "hemispheres be split less deeply or above a larger threshold."
        )
    return PaperRays(guide, rules.right), look_rays, float(guide.guided.mean())


def refuse_too_many(rays: int, patches: int) -> None:
    """Raise SettingsError for more than ``MOST_TRACED`` rays."""
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
    on_step: StepCallback,
    way: Way = evenly,
    guided: Chosen | None = None,
) -> Traced:
    """Return the hits of ``rays`` rays of every patch.

    ``surroundings``: whether light of the surroundings is gathered; ``way``, ``guided``: as for ``gather``.
    """
    order, hits, weights, around = [], [], [], np.zeros((len(patches), 3))
    dark = patches.see(np.zeros((len(patches), 3)), surroundings)
    done = 0
    for points, point_way in passes(len(patches), rays, way, guided):
        on_step("rays", done, len(patches))
        ray, weight = hemisphere_rays(groups, points, rays, point_way, seed)
        patch, radiance = dark(ray)
        arriving = [channel * weight for channel in radiance]
        weight /= dr.pi
        dr.eval(patch, weight, arriving)
        order.append(points)
        hits.append(patch)
        weights.append(weight)
        around[points] = sums_of_rays(arriving, rays)
        done += len(points)
    return Traced(rays, np.concatenate(order), hits, weights, around)


def finish(
    patches: Patches,
    traced: Traced,
    direct: Floats,
    residual: float,
    lights: bool,
    extra_rays: int,
    guided: float,
    on_step: StepCallback,
) -> Solution:
    """Return the solution along traced rays, in rounds.

    ``direct`` (P, 3): irradiance straight from emitters; with ``lights``, rays do not bring what emitters emit.
    ``extra_rays``: rays of each patch spent on other purposes, for the count. ``guided``: share of guided patches.
    """
    arriving = direct + traced.around
    supplied = float(np.sum(patches.areas[:, None] * (patches.emitted + patches.albedo * arriving)))
    radiosity, irradiance = patches.emitted, arriving
    change, done = np.inf, 0
    on_step("rounds", done, MOST_ROUNDS)
    while change > residual and done < MOST_ROUNDS:
        irradiance = arriving + gathered(traced, radiosity - patches.emitted if lights else radiosity)
        following = patches.emitted + patches.albedo * irradiance
        moved = float(np.sum(patches.areas[:, None] * np.abs(following - radiosity))) / max(supplied, 1e-300)
        if done >= HOPE and moved > COARSE and rounds_left(moved, moved / change, residual) > MOST_ROUNDS:
            of_the_last = f"a round does {100 * moved / change:.2f} % of the one before"
            raise SceneError(endless(of_the_last, patches, energy_of(patches, traced)))
        change, radiosity, done = moved, following, done + 1
        on_step(f"round {done}: {change:.1e} of the power moved", min(done, MOST_ROUNDS - 1), MOST_ROUNDS)
    rays = (traced.rays + extra_rays) * len(patches)
    return Solution(radiosity, irradiance, change, done, rays, guided, energy_of(patches, traced))


def energy_of(patches: Patches, traced: Traced) -> float:
    """Return the mean over patches of the sum of the weights of their rays."""
    wide = dr.float64_array_t(mi.Float)
    energies = [
        dr.width(hit) * float(dr.mean(wide(weight))[0]) for hit, weight in zip(traced.hits, traced.weights, strict=True)
    ]
    return sum(energies) / len(patches)


def endless(finding: str, patches: Patches, energy: float) -> str:
    """Return the sentence that light does not come to an end, with what was found and what can be done.

    ``energy``: what the rays of a patch carry, as a share of its energy.
    """
    remedy = "make it less than 1, or let some light out"
    if energy > 1 + 1e-3:
        remedy = f"by the paper's rules rays carry {100 * energy:.1f} % of the energy there is; choose paper_right"
    return f"Light goes to and fro for ever: {finding}. The largest albedo is {patches.albedo.max():.4g}; {remedy}."


def rounds_left(change: float, ratio: float, residual: float) -> float:
    """Return the number of rounds from ``change`` to ``residual`` if a round multiplies the change by ``ratio``."""
    if change <= residual:
        return 0.0
    return float(np.log(residual / change) / np.log(ratio)) if ratio < 1 else np.inf


def gathered(traced: Traced, radiosity: Floats) -> Floats:
    """Return the mean radiosity (P, 3) of what the rays of each patch hit, weighted by the weights of the rays."""
    means = np.zeros_like(radiosity)
    for channel, values in enumerate(radiosity.T):
        table = upload(mi.Float, values)
        sums = [
            sums_of_rays([dr.gather(mi.Float, table, hit, hit != NOTHING) * weight], traced.rays)[:, 0]
            for hit, weight in zip(traced.hits, traced.weights, strict=True)
        ]
        means[traced.order, channel] = np.concatenate(sums)
    return means
