"""The albedo of materials, a number for each channel: radiosity uses nothing else of a material."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.core.device import divide, to_unit
from tracer.core.hashing import GOLDEN_RATIO, mix

TRIES = 64
"""Number of directions sampled from a material that is not diffuse, at each place, to estimate its albedo."""
MIRROR = 0.99
"""Largest albedo of a material that is not diffuse: light between two perfect mirrors would never come to rest."""


def not_diffuse(bsdf: Any) -> Any:
    """Return whether a material does anything but reflect diffusely; for mi.BSDFPtr, for each of its materials."""
    glossy, delta, null = (
        mi.has_flag(bsdf.flags(), flag) for flag in (mi.BSDFFlags.Glossy, mi.BSDFFlags.Delta, mi.BSDFFlags.Null)
    )
    return glossy | delta | null


def albedo(bsdf: Any, interaction: Any) -> Floats:
    """Return the share (N, 3) of evenly incident light that is reflected to the side of ``interaction.wi``.

    For a diffuse material this is its reflectance. Any other material is treated as a diffuse one that reflects the
    same share of light, at most ``MIRROR``; light that passes through it is lost.
    """
    count = dr.width(interaction)
    if not not_diffuse(bsdf):
        return np.array(bsdf.eval_diffuse_reflectance(interaction), np.float64).T.reshape(-1, 3)
    source, index = divide(dr.arange(mi.UInt32, count * TRIES), TRIES)
    queries = dr.gather(type(interaction), interaction, source)
    bits = mix(source ^ 0x2F0B4C47)
    u = (mi.Float(index) + to_unit(bits)) / TRIES
    v, w, s, t = (to_unit(index * GOLDEN_RATIO + mix(bits)), *(to_unit(mix(bits ^ (index * k + k))) for k in (3, 5, 7)))
    front = dr.sign(queries.wi.z)
    queries.wi = mi.warp.square_to_cosine_hemisphere(mi.Point2f(u, v)) * mi.Vector3f(1, 1, front)
    sampled, weight = bsdf.sample(mi.BSDFContext(), queries, w, mi.Point2f(s, t))
    returned = sampled.wo.z * queries.wi.z > 0
    channels = [
        dr.block_sum(dr.select(returned & dr.isfinite(channel), channel, 0), TRIES) / TRIES for channel in weight
    ]
    dr.eval(channels)
    return np.minimum(np.stack([channel.numpy() for channel in channels], axis=-1).astype(np.float64), MIRROR)
