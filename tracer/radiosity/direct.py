"""Light that comes straight from emitters: rays distributed as the cosine rarely hit a small lamp."""

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
    """Do nothing: the progress callback of a caller who does not ask for progress."""


def direct_light(scene: Any, interaction: Any, normal: Any, sample: Any, active: Any) -> Any:
    """Return an estimate of the irradiance (mi.Color3f) at places on the side of ``normal``.

    It takes one place on one light; ``sample`` (mi.Point2f) chooses both the light and the place.
    """
    direction, weight = scene.sample_emitter_direction(interaction, sample, True, active)
    cosine = dr.dot(direction.d, normal)
    return dr.select(active & (direction.pdf > 0) & (cosine > 0), mi.Color3f(weight) * cosine, 0)


def direct_of_patches(patches: Patches, rays: int, seed: int = 0, on_step: StepCallback = silent) -> Floats:
    """Return the irradiance (P, 3) of patches straight from emitters, from ``rays`` places on emitters a patch."""
    irradiances = []
    patches_per_pass = max(1, MOST_RAYS // rays)
    for first in range(0, len(patches), patches_per_pass):
        patch_count = min(patches_per_pass, len(patches) - first)
        on_step("lights", first, len(patches))
        patch, ray_index = divide(dr.arange(mi.UInt32, patch_count * rays), rays)
        patch += dr.opaque(mi.UInt32, first)
        _, u, v = lattice(patch, ray_index, dr.opaque(mi.UInt32, rays), seed + 0x4088615C)
        interaction = dr.zeros(mi.Interaction3f, patch_count * rays)
        place, normal = (
            mi.Vector3f(*(dr.gather(mi.Float, coordinates, 3 * patch + k) for k in range(3)))
            for coordinates in patches.points.rows
        )
        interaction.p = mi.Point3f(place)
        interaction.n = mi.Normal3f(normal)
        light = direct_light(patches.scene, interaction, normal, mi.Point2f(u, v), True)
        irradiances.append(sums_of_rays(list(light), rays) / rays)
    return np.concatenate(irradiances)
