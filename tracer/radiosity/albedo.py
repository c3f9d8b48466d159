"""What materials reflect, as a number for each channel: radiosity knows no other."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.core.device import divide, to_unit
from tracer.core.hashing import GOLDEN_RATIO, mix

TRIES = 64
"""Directions that a material that is not diffuse is asked for, at each place."""
MIRROR = 0.99
"""Most that such a material reflects: two perfect mirrors would never come to rest."""


def not_diffuse(bsdf: Any) -> Any:
    """Return whether a material (or each of mi.BSDFPtr) does anything but reflect diffusely."""
    glossy, delta, null = (
        mi.has_flag(bsdf.flags(), kind) for kind in (mi.BSDFFlags.Glossy, mi.BSDFFlags.Delta, mi.BSDFFlags.Null)
    )
    return glossy | delta | null


def albedo(bsdf: Any, interaction: Any) -> Floats:
    """Return the share (N, 3) of light that leaves again on the side of ``interaction.wi``.

    Light that falls in evenly from all around: of diffuse materials it is their reflectance. Others are treated as if
    they were diffuse and reflected as much, or nearly if it is all; what passes through them is lost.
    """
    count = dr.width(interaction)
    if not not_diffuse(bsdf):
        return np.array(bsdf.eval_diffuse_reflectance(interaction), np.float64).T.reshape(-1, 3)
    place, number = divide(dr.arange(mi.UInt32, count * TRIES), TRIES)
    asked = dr.gather(type(interaction), interaction, place)
    key = mix(place ^ 0x2F0B4C47)
    u = (mi.Float(number) + to_unit(key)) / TRIES
    v, w, s, t = (to_unit(number * GOLDEN_RATIO + mix(key)), *(to_unit(mix(key ^ (number * k + k))) for k in (3, 5, 7)))
    front = dr.sign(asked.wi.z)
    asked.wi = mi.warp.square_to_cosine_hemisphere(mi.Point2f(u, v)) * mi.Vector3f(1, 1, front)
    sampled, weight = bsdf.sample(mi.BSDFContext(), asked, w, mi.Point2f(s, t))
    back = sampled.wo.z * asked.wi.z > 0
    total = [dr.block_sum(dr.select(back & dr.isfinite(channel), channel, 0), TRIES) / TRIES for channel in weight]
    dr.eval(total)
    return np.minimum(np.stack([channel.numpy() for channel in total], axis=-1).astype(np.float64), MIRROR)
