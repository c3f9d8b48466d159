"""The radiosity of all patches by progressive shooting (the paper, section 4.2): the brightest send their light first.

A step takes the patches with the most unsent power, which have half of all unsent power together, and sends their
power along rays of about equal power, which leave from all over the patch. A ray of triangle T carries
Phi Omega'_T / (pi n_T), so that a patch sends exactly its power Phi: all emitted power is absorbed, lost or still
unsent, within the rounding of double precision. By the paper's rules for rays this does not hold: as they are printed,
a patch sends more or less than its power, and with the energies made right it sends its power on average.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats, Integers
from tracer.core.device import to_unit, upload
from tracer.core.hashing import mix
from tracer.errors import SceneError
from tracer.progress import StepCallback
from tracer.radiosity.direct import silent
from tracer.radiosity.gathering import COARSE, HOPE, endless, paper_way, refuse_too_many, trace
from tracer.radiosity.groups import Groups, alone, neighbours
from tracer.radiosity.guide import Guidance, division_for, make_guide
from tracer.radiosity.hemisphere import MOST_RAYS, NOTHING
from tracer.radiosity.lattice import Way, evenly, randomly
from tracer.radiosity.paper import PaperRules
from tracer.radiosity.patches import Patches, by_face
from tracer.radiosity.placed_cells import cells_of_patches, placed_cells
from tracer.radiosity.spread import RANDOMLY, Spread
from tracer.radiosity.strata import Strata

AT_ONCE = 0.5
"""Share of the unsent power that a step sends, at least."""
STEPS = 0xC13FA9A9, 0x91E10DA5
"""2^32 over the plastic number, and over its square: the steps of a sequence whose places fill a square evenly.

M. Roberts, "The unreasonable effectiveness of quasirandom sequences" (2018).
"""
MOST_STEPS = 10_000
"""Largest number of steps of a solution."""


@dataclass(frozen=True)
class ShootingSolution:
    """Radiosity of patches, and where the power went."""

    radiosity: Floats
    """(P, 3): power per area that leaves each patch, including power that is unsent."""
    irradiance: Floats
    """(P, 3): power per area that has arrived."""
    supplied: Floats
    """(3,): power that is emitted, or arrives from the surroundings and is reflected at once."""
    absorbed: Floats
    """(3,): power that arrived at patches and was not reflected."""
    lost: Floats
    """(3,): power that missed all patches, or hit a back that is no patch."""
    unsent: Floats
    """(3,): power that was still unsent at the end."""
    residual: float
    """Unsent power as a share of the supplied power."""
    rounds: int
    """Number of steps."""
    rays: int
    """Number of rays traced, including those that looked and those to the surroundings."""
    guided: float = 0.0
    """Share of the patches whose rays were guided."""
    energy: float = 1.0
    """Power that rays carried over the power that patches sent along them: 1 if energy is conserved."""


def shoot(
    patches: Patches,
    rays: int = 256,
    residual: float = 1e-5,
    seed: int = 0,
    spread: Spread = None,
    on_step: StepCallback = silent,
) -> ShootingSolution:
    """Return the solution, shot until no more than the share ``residual`` of the supplied power is unsent.

    ``rays``: number of rays of each patch on average, for the supplied power; power that is reflected later takes more
    rays. Raises SettingsError for too many rays, and SceneError if the steps do not converge.
    """
    refuse_too_many(rays, len(patches))
    if isinstance(spread, PaperRules):
        groups = alone(patches.points)
        way, looks, guided = paper_way(patches, spread, rays, seed)
        look_rays = looks * len(patches)
    else:
        guidance = spread if isinstance(spread, Guidance) else None
        groups = neighbours(patches.points, guidance.members if guidance else MOST_RAYS)
        way, look_rays, guided = way_for(patches, groups, rays, guidance, seed)
        way = randomly if spread == RANDOMLY else way
    around = np.zeros((len(patches), 3))
    if patches.scene.environment() is not None:
        around = trace(patches, groups, rays, seed, True, on_step).around
        look_rays += rays * len(patches)
    areas = patches.areas[:, None]
    received = areas * around
    unsent = areas * patches.emitted + patches.albedo * received
    supplied = unsent.sum(axis=0)
    # Light of the surroundings that is absorbed at once never becomes power of a patch, so it is not counted.
    absorbed, lost = np.zeros(3), np.zeros(3)
    grey = max(float(supplied.mean()), 1e-300)
    power_of_ray = grey / (rays * len(patches))
    sent, steps, leave = 0, 0, Leaving(patches, groups)
    leaving_power, carried_power = 1e-300, 1e-300
    while unsent.sum() / 3 > residual * grey and steps < MOST_STEPS:
        left = float(unsent.sum() / 3 / grey)
        if steps >= HOPE and left > COARSE and steps * np.log(residual) / np.log(min(left, 1 - 1e-9)) > MOST_STEPS:
            left_after = f"{100 * left:.0f} % is left after {steps} steps"
            raise SceneError(endless(left_after, patches, carried_power / leaving_power))
        on_step(f"step {steps}: {left:.1e} of the power left", int(100 * progress(left, residual)), 100)
        chosen = brightest(unsent.mean(axis=1))
        counts = np.minimum(np.ceil(unsent[chosen].mean(axis=1) / power_of_ray), MOST_RAYS).astype(np.int64)
        arriving, missing = send(
            patches, leave, way, chosen, counts, unsent[chosen], seed + 1 + steps, not isinstance(spread, PaperRules)
        )
        leaving_power += float(unsent[chosen].sum())
        carried_power += float(arriving.sum() + missing.sum())
        unsent[chosen] = 0
        received += arriving
        unsent += patches.albedo * arriving
        absorbed += ((1 - patches.albedo) * arriving).sum(axis=0)
        lost += missing
        sent, steps = sent + int(counts.sum()), steps + 1
    irradiance = received / areas
    radiosity = patches.emitted + patches.albedo * irradiance
    final_share = float(unsent.sum() / 3 / grey)
    left_unsent, rays = unsent.sum(axis=0), sent + look_rays
    energy = carried_power / leaving_power
    return ShootingSolution(
        radiosity, irradiance, supplied, absorbed, lost, left_unsent, final_share, steps, rays, guided, energy
    )


def way_for(
    patches: Patches, groups: Groups, rays: int, guidance: Guidance | None, seed: int
) -> tuple[Way, int, float]:
    """Return the way in which rays are spread, the number of rays that looked for it, and the share of guided patches.

    Rays look at patches only, because no radiosity is known yet.
    """
    division = division_for(guidance, rays) if guidance else None
    if guidance is None or division is None:
        return evenly, 0, 0.0
    see = by_face(patches, patches.see(np.zeros((len(patches), 3)), surroundings=False))
    # Without light no gain can be estimated, so that every group is guided.
    guide = make_guide(see, groups, division, replace(guidance, worth=0.0, overall=0.0), patches.faces, seed)
    return Strata(guide), guide.regions.rays, float(guide.guided.mean())


def progress(left: float, residual: float) -> float:
    """Return the part of the way, 0 to 1, that the share ``left`` of unsent power has come from 1 to ``residual``.

    The way is measured in logarithms.
    """
    return float(np.clip(np.log(max(left, 1e-30)) / np.log(residual), 0, 1))


def brightest(power: Floats) -> Integers:
    """Return the patches with the most unsent power: the fewest that have the share ``AT_ONCE`` of it together."""
    order = np.argsort(-power, kind="stable")
    count = np.searchsorted(np.cumsum(power[order]), AT_ONCE * power.sum()) + 1
    chosen: Integers = order[:count]
    return chosen[power[chosen] > 0]


class Leaving:
    """Rays that leave patches from all over their triangles.

    All rays from the middle would make a lamp of a large patch: what is near it would get the light of a point.
    """

    def __init__(self, patches: Patches, groups: Groups) -> None:
        corners = placed_cells(patches)[0][cells_of_patches(patches)]
        self.groups = groups
        self.first_edge, self.second_edge = (upload(mi.Float, corners[:, k] - corners[:, 0]) for k in (1, 2))

    def __call__(self, point: Any, ray_index: Any, local: Any, seed: int) -> Any:
        """Return rays (mi.Ray3f) of patches (mi.UInt32) in local directions; ``ray_index``: number of the ray."""
        ray = self.groups.leave(point, local)
        bits = mix(point ^ mix(dr.opaque(mi.UInt32, (seed + 0x2545F491) & 0xFFFFFFFF)))
        u, v = (to_unit(ray_index * step + key) for step, key in zip(STEPS, (bits, mix(bits)), strict=True))
        place = mi.warp.square_to_uniform_triangle(mi.Point2f(u, v)) - 1 / 3
        first, second = (
            mi.Vector3f(*(dr.gather(mi.Float, edge, 3 * point + k) for k in range(3)))
            for edge in (self.first_edge, self.second_edge)
        )
        ray.o += first * place.x + second * place.y
        return ray


def send(
    patches: Patches,
    leave: Leaving,
    way: Way,
    chosen: Integers,
    counts: Integers,
    power: Floats,
    seed: int,
    is_conserved: bool = True,
) -> tuple[Floats, Floats]:
    """Return the power that arrives at all patches (P, 3), and the power that misses them (3,).

    ``chosen`` (C,): numbers of the patches that send. ``counts`` (C,) and ``power`` (C, 3): their rays and the power
    that they send. ``is_conserved``: whether the weights of a patch add up to pi but for the rounding of single
    precision, which is then taken away; otherwise power is gained or lost by what they add up to.
    """
    wide = dr.float64_array_t(mi.Float)
    arrived = [dr.zeros(wide, len(patches) + 1) for _ in range(3)]
    ends = np.cumsum(counts)
    begin = 0
    while begin < len(chosen):
        before = ends[begin] - counts[begin]
        end = max(begin + 1, int(np.searchsorted(ends, before + MOST_RAYS, side="right")))
        batch = slice(begin, end)
        lane = upload(mi.UInt32, np.repeat(np.arange(end - begin), counts[batch]))
        point, ray_count, start = (
            dr.gather(mi.UInt32, upload(mi.UInt32, values), lane)
            for values in (chosen[batch], counts[batch], ends[batch] - counts[batch] - before)
        )
        ray_index = dr.arange(mi.UInt32, dr.width(lane)) - start
        local, weight = way(point, ray_index, ray_count, seed)
        hit = patches.find(leave(point, ray_index, local, seed))
        weights = wide(weight)
        if is_conserved:
            total = dr.zeros(wide, end - begin)
            dr.scatter_add(total, weights, lane)
            weights /= dr.gather(wide, total, lane)
        else:
            weights /= np.pi
        target = dr.select(hit == NOTHING, len(patches), hit)
        for channel in range(3):
            dr.scatter_add(arrived[channel], weights * dr.gather(wide, wide(power[batch, channel]), lane), target)
        dr.eval(arrived)
        begin = end
    sums = np.stack([sum_of_channel.numpy() for sum_of_channel in arrived], axis=-1)
    return sums[:-1], sums[-1]
