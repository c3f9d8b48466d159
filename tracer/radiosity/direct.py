"""Light that comes straight from emitters: a small lamp is rarely found by rays that leave as the cosine does."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.core.device import divide
from tracer.progress import StepCallback
from tracer.radiosity.hemisphere import MOST_RAYS
from tracer.radiosity.irradiance import sums_of_rays
from tracer.radiosity.lattice import lattice
from tracer.radiosity.patches import Patches


def silent(text: str, done: int, total: int) -> None:
    """Tell nobody."""


def direct_light(scene: Any, interaction: Any, normal: Any, sample: Any, active: Any) -> Any:
    """Return an estimate of the irradiance (mi.Color3f) at places on the side of ``normal``.

    It is from one place on a light, both chosen by ``sample`` (mi.Point2f).
    """
    direction, weight = scene.sample_emitter_direction(interaction, sample, True, active)
    cosine = dr.dot(direction.d, normal)
    return dr.select(active & (direction.pdf > 0) & (cosine > 0), mi.Color3f(weight) * cosine, 0)


def direct_of_patches(patches: Patches, rays: int, seed: int = 0, told: StepCallback = silent) -> Floats:
    """Return the irradiance (P, 3) that patches have from emitters, with ``rays`` places on them for each patch."""
    found = []
    most = max(1, MOST_RAYS // rays)
    for first in range(0, len(patches), most):
        count = min(most, len(patches) - first)
        told("lights", first, len(patches))
        patch, number = divide(dr.arange(mi.UInt32, count * rays), rays)
        patch += dr.opaque(mi.UInt32, first)
        _, u, v = lattice(patch, number, dr.opaque(mi.UInt32, rays), seed + 0x4088615C)
        interaction = dr.zeros(mi.Interaction3f, count * rays)
        place, normal = (
            mi.Vector3f(*(dr.gather(mi.Float, rows, 3 * patch + k) for k in range(3))) for rows in patches.points.rows
        )
        interaction.p = mi.Point3f(place)
        interaction.n = mi.Normal3f(normal)
        light = direct_light(patches.scene, interaction, normal, mi.Point2f(u, v), True)
        found.append(sums_of_rays(list(light), rays) / rays)
    return np.concatenate(found)
