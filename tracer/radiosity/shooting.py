"""The radiosity of all patches by progressive shooting (the paper, section 4.2): the brightest send their light first.

A step takes the patches that have most left to send, together half of all that is left, and sends it along rays of
about one power. A ray of triangle T carries Phi Omega'_T / (pi n_T), so that all of it is sent, and what is emitted is
absorbed, lost or still to be sent, to the last bit that double precision keeps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.core.device import upload
from tracer.errors import SceneError
from tracer.progress import StepCallback
from tracer.radiosity.direct import silent
from tracer.radiosity.gathering import COARSE, HOPE, refuse_too_many, trace
from tracer.radiosity.groups import Groups, neighbours
from tracer.radiosity.guide import Guidance, division_for, make_guide
from tracer.radiosity.hemisphere import MOST_RAYS, NOTHING
from tracer.radiosity.lattice import Way, evenly
from tracer.radiosity.patches import Patches, by_face
from tracer.radiosity.strata import Strata

Integers = NDArray[np.int64]
AT_ONCE = 0.5
"""Share of what is left that a step sends."""
MOST_STEPS = 10_000


@dataclass(frozen=True)
class Shot:
    """Radiosity of patches, and where the power went."""

    radiosity: Floats
    """(P, 3): power per area that leaves each patch, what it has yet to send too."""
    supplied: Floats
    """(3,): power that is emitted, or comes from around and is reflected at once."""
    absorbed: Floats
    """(3,): power that patches did not reflect."""
    lost: Floats
    """(3,): power that went past all patches, or hit a side that is none."""
    unsent: Floats
    """(3,): power that was not sent yet when enough was."""
    residual: float
    """Share of the power that is unsent."""
    rounds: int
    rays: int
    guided: float = 0.0
    """Share of the patches whose rays were guided."""


def shoot(
    patches: Patches,
    rays: int = 256,
    residual: float = 1e-5,
    seed: int = 0,
    guidance: Guidance | None = None,
    told: StepCallback = silent,
) -> Shot:
    """Return the solution when a share ``residual`` of the power is left to send.

    ``rays``: of each patch on average, for the power that is emitted; reflected power takes more of them.
    """
    refuse_too_many(rays, len(patches))
    groups = neighbours(patches.points, guidance.members if guidance else MOST_RAYS)
    way, looked, guided = way_for(patches, groups, rays, guidance, seed)
    around = np.zeros((len(patches), 3))
    if patches.scene.environment() is not None:
        around = trace(patches, groups, rays, seed, True, told).around
        looked += rays * len(patches)
    areas = patches.areas[:, None]
    received = areas * around
    unsent = areas * patches.emitted + patches.albedo * received
    supplied = unsent.sum(axis=0)
    # What the surroundings bring and is absorbed at once is not power of a patch.
    absorbed, lost = np.zeros(3), np.zeros(3)
    grey = max(float(supplied.mean()), 1e-300)
    one_ray = grey / (rays * len(patches))
    sent, steps = 0, 0
    while unsent.sum() / 3 > residual * grey and steps < MOST_STEPS:
        left = float(unsent.sum() / 3 / grey)
        if steps >= HOPE and left > COARSE and steps * np.log(residual) / np.log(min(left, 1 - 1e-9)) > MOST_STEPS:
            raise SceneError(
                f"Light goes to and fro for ever: {100 * left:.0f} % is left after {steps} steps. The largest albedo "
                f"is {patches.albedo.max():.4g}; make it less than 1, or let some light out."
            )
        told(f"step {steps}: {left:.1e} of the power left", int(100 * progress(left, residual)), 100)
        chosen = brightest(unsent.mean(axis=1))
        counts = np.minimum(np.ceil(unsent[chosen].mean(axis=1) / one_ray), MOST_RAYS).astype(np.int64)
        arrived, missed = send(patches, groups, way, chosen, counts, unsent[chosen], seed + 1 + steps)
        unsent[chosen] = 0
        received += arrived
        unsent += patches.albedo * arrived
        absorbed += ((1 - patches.albedo) * arrived).sum(axis=0)
        lost += missed
        sent, steps = sent + int(counts.sum()), steps + 1
    radiosity = patches.emitted + patches.albedo * received / areas
    rest = float(unsent.sum() / 3 / grey)
    return Shot(radiosity, supplied, absorbed, lost, unsent.sum(axis=0), rest, steps, sent + looked, guided)


def way_for(
    patches: Patches, groups: Groups, rays: int, guidance: Guidance | None, seed: int
) -> tuple[Way, int, float]:
    """Return how rays leave, how many looked for it, and the share of patches guided.

    They look at patches, not at light: all is dark yet.
    """
    division = division_for(guidance, rays) if guidance else None
    if guidance is None or division is None:
        return evenly, 0, 0.0
    see = by_face(patches, patches.see(np.zeros((len(patches), 3)), surroundings=False))
    # Without light there is no telling what is worth it.
    guide = make_guide(see, groups, division, replace(guidance, worth=0.0, overall=0.0), patches.faces, seed)
    return Strata(guide), guide.regions.rays, float(guide.guided.mean())


def progress(left: float, residual: float) -> float:
    """Return how far from 1 to the residual what is left has come, in logarithms."""
    return float(np.clip(np.log(max(left, 1e-30)) / np.log(residual), 0, 1))


def brightest(power: Floats) -> Integers:
    """Return the patches that have most to send, as many as have ``AT_ONCE`` of it together."""
    order = np.argsort(-power, kind="stable")
    some = np.searchsorted(np.cumsum(power[order]), AT_ONCE * power.sum()) + 1
    chosen: Integers = order[:some]
    return chosen[power[chosen] > 0]


def send(
    patches: Patches, groups: Groups, way: Way, chosen: Integers, counts: Integers, power: Floats, seed: int
) -> tuple[Floats, Floats]:
    """Return the power that arrives at all patches (P, 3) and that misses them (3,), of ``power`` (C, 3) sent.

    ``counts`` (C,): rays of the patches ``chosen`` (C,).
    """
    wide = dr.float64_array_t(mi.Float)
    arrived = [dr.zeros(wide, len(patches) + 1) for _ in range(3)]
    ends = np.cumsum(counts)
    begin = 0
    while begin < len(chosen):
        before = ends[begin] - counts[begin]
        end = max(begin + 1, int(np.searchsorted(ends, before + MOST_RAYS, side="right")))
        some = slice(begin, end)
        lane = upload(mi.UInt32, np.repeat(np.arange(end - begin), counts[some]))
        point, many, start = (
            dr.gather(mi.UInt32, upload(mi.UInt32, each), lane)
            for each in (chosen[some], counts[some], ends[some] - counts[some] - before)
        )
        local, weight = way(point, dr.arange(mi.UInt32, dr.width(lane)) - start, many, seed)
        hit = patches.find(groups.leave(point, local))
        weights = wide(weight)
        # Single precision loses some of it: what stands for pi together is pi.
        total = dr.zeros(wide, end - begin)
        dr.scatter_add(total, weights, lane)
        weights /= dr.gather(wide, total, lane)
        target = dr.select(hit == NOTHING, len(patches), hit)
        for k in range(3):
            dr.scatter_add(arrived[k], weights * dr.gather(wide, wide(power[some, k]), lane), target)
        dr.eval(arrived)
        begin = end
    found = np.stack([channel.numpy() for channel in arrived], axis=-1)
    return found[:-1], found[-1]
