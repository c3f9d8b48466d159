"""Illuminance in lux, and what it is on each surface of a scene.

Illuminance is 683 lm/W times the integral of spectral irradiance times V(lambda) (CIE 1924, BIPM 2019). A picture of
red, green and blue keeps no spectrum: its channels, in W/m^2 each, are taken as amounts of the sRGB primaries, whose
weights in the CIE's Y stand for V(lambda). White of 1 W/m^2 in each channel is therefore 683 lx.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tracer.core.arrays import Floats, Integers
from tracer.errors import SettingsError
from tracer.image.colour import luminance
from tracer.radiosity.patches import Patches
from tracer.radiosity.placed_cells import cells_of_patches, placed_cells, shapes_with_faces
from tracer.scene.shape_names import label_of, material_name

EFFICACY = 683.0
"""Lumens per watt of radiation of 555 nm, where the eye sees best."""

HIDDEN = 0.01
"""Share of the illuminance of the other side below which a side of a shape is not listed."""


def illuminance(irradiance: ArrayLike, efficacy: float = EFFICACY) -> Floats:
    """Return the illuminance (...) in lux of an irradiance (..., 3) in linear sRGB.

    ``efficacy``: lumens in a unit of the scene's light; 683 if its lights are in watts, 1 if they are in lumens.
    """
    return efficacy * luminance(irradiance)


def check_efficacy(efficacy: float) -> None:
    """Raise SettingsError for an efficacy that is no number above 0."""
    if not 0 < efficacy < float("inf"):
        raise SettingsError(f"The efficacy is a number of lumens above 0, not {efficacy:g}.")


@dataclass(frozen=True)
class LitSurface:
    """The illuminance of one side of a shape, by the area of its patches."""

    name: str
    """Name of the shape; of its back with the word "back" after it."""
    material: str
    """Name of its material, "" if it has none."""
    area: float
    """In square units of the scene."""
    mean: float
    """Mean over the area, in lux."""
    least: float
    greatest: float

    @property
    def uniformity(self) -> float:
        """Least over mean illuminance, 0 to 1 (EN 12464-1: U0); 0 without light."""
        return self.least / self.mean if self.mean > 0 else 0.0


def lit_surfaces(patches: Patches, lux: Floats) -> list[LitSurface]:
    """Return the illuminance of the sides of all shapes, the largest area first; ``lux`` (P,) is that of the patches.

    A side is left out if it has less than the share ``HIDDEN`` of the mean of the other side: it is the inside of a
    thing or the outside of a room, into which a little light leaks beside the edges of patches.
    """
    shapes = shapes_with_faces(patches)
    side = side_of_patches(patches)
    count = 2 * len(shapes)
    area = np.bincount(side, patches.areas, count)
    flux = np.bincount(side, patches.areas * lux, count)
    least, greatest = np.full(count, np.inf), np.zeros(count)
    np.minimum.at(least, side, lux)
    np.maximum.at(greatest, side, lux)
    mean = flux / np.maximum(area, 1e-300)
    other_side = np.arange(count) ^ 1
    is_front = np.arange(count) % 2 == 0
    is_shown = (area > 0) & (mean >= HIDDEN * mean[other_side]) & (is_front | (mean > 0))
    order = np.argsort(-area, kind="stable")
    return [
        LitSurface(
            label_of(shapes[index // 2], index // 2 + 1) + (", back" if index % 2 else ""),
            material_name(shapes[index // 2].bsdf()),
            *(float(values[index]) for values in (area, mean, least, greatest)),
        )
        for index in order[is_shown[order]].tolist()
    ]


def side_of_patches(patches: Patches) -> Integers:
    """Return the side (P,) that each patch is on: 2 k for the front of shape k, 2 k + 1 for its back."""
    _, _, shape = placed_cells(patches)
    is_back = np.arange(len(patches)) >= len(shape)
    return 2 * shape[cells_of_patches(patches)] + is_back
