"""Quick pictures of views, lit from the eye, whatever light the scene has."""

from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core.arrays import Floats
from tracer.core.device import divide, upload
from tracer.image.colour import encode_srgb
from tracer.viewpoint.item_buffer import Rays, Viewpoints, world_ray
from tracer.viewpoint.lens import Lens
from tracer.viewpoint.surfaces import Subject

FINER = 3
"""A pixel has this many rays along each of its sides."""
BACKGROUND = 0.9
"""The background has this linear brightness, 0 to 1."""
AMBIENT = 0.15
"""This share of the light comes from all directions; the rest comes from the eye."""


def look(
    subject: Subject, viewpoints: Viewpoints, lens: Lens, size: int, colours: Floats | None = None
) -> list[Floats]:
    """Return a picture (rows, size, 3) of each view in [0, 1], encoded as sRGB; the lens determines the rows.

    ``colours``: (F, 3), linear, of the faces; by default the diffuse reflectance of their materials.
    """
    return [look_once(subject, viewpoints[k : k + 1], lens, size, colours) for k in range(len(viewpoints))]


def look_once(subject: Subject, viewpoint: Viewpoints, lens: Lens, size: int, colours: Floats | None) -> Floats:
    """Return the picture (rows, size, 3) of one viewpoint, see ``look``."""
    rows = Rays(side=size).rows(lens)
    count = FINER**2 * size * rows
    row, column = divide(dr.arange(mi.UInt32, count), size * FINER)
    width, height = dr.opaque(mi.Float, 1 / (size * FINER)), dr.opaque(mi.Float, 1 / (rows * FINER))
    first_viewpoint = dr.zeros(mi.UInt32, count)
    ray, _ = world_ray(
        viewpoint, lens, first_viewpoint, (mi.Float(column) + 0.5) * width, (mi.Float(row) + 0.5) * height
    )
    intersection = subject.scene.ray_intersect_preliminary(ray, coherent=True)
    hit = intersection.is_valid()
    interaction = intersection.compute_surface_interaction(ray, mi.RayFlags.All, hit)
    if colours is None:
        reflectance = interaction.bsdf().eval_diffuse_reflectance(interaction, hit)
        colour = mi.Color3f(dr.clip(reflectance, 0.02, 1.0))
    else:
        table = upload(mi.Float, colours)
        face = subject.face(intersection)
        colour = mi.Color3f(*(dr.gather(mi.Float, table, 3 * face + k, hit) for k in range(3)))
    cosine = dr.abs(dr.dot(interaction.sh_frame.n, ray.d))
    shaded = dr.select(hit, colour * (AMBIENT + (1 - AMBIENT) * cosine), BACKGROUND)
    image = np.array(shaded, np.float64).T.reshape(rows, FINER, size, FINER, 3).mean(axis=(1, 3))
    return np.asarray(encode_srgb(np.nan_to_num(image)))
