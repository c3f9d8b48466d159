"""Pixels of something far brighter than its surroundings, and beside it: a lamp, its mirror image, the sun on metal.

A denoiser lets a small part of a bright pixel bleed into its neighbours and wipes out a bright pixel that stands alone,
and the look of a film's filter is imitated up to a small part of a bright pixel as well. A small part of something a
thousand times brighter is more than all the light of a dark pixel, and all of it is much of the light of a picture, so
such pixels stay as they were drawn. A pixel's own standard error tells a lamp from a firefly: a firefly's is as large
as its mean.
"""

from __future__ import annotations

import numpy as np

from tracer.core.arrays import Mask, Singles
from tracer.denoising.neighbours import blurred, extreme

CONTRASTS = {3: 4.0, 5: 40.0}
"""Brightness of the brightest pixel in a square around a pixel, in multiples of the pixel's own, from which on the
pixel is beside glare, by the side of the square."""
GLARING = 30.0
"""Brightness of a pixel, in multiples of the darkest pixel around, from which on it is glaring itself."""
AROUND = 5
"""Side in pixels of the square in which the darkest pixel is looked for."""
SIDE_TAP = 0.2
"""Weight of each neighbour in the blur after which darker pixels are compared."""
DARKEST = 0.3
"""Brightness, over that of the brighter pixels of the picture, that a pixel is taken to have at least: before a black
background nothing is glaring that is not far brighter than those."""
CERTAIN = 5.0**0.5
"""Least brightness of a certain pixel, in its own standard errors."""
LEAST_COUNT = 4
"""Least samples that tell a standard error: where few samples find light, hardly ever do that many fall into one
pixel."""


def is_certain(grey: Singles, squared_errors: Singles, count: Singles) -> Mask:
    """Return which pixels (H, W) are certainly about as bright, with those around them, as their samples say.

    ``grey`` and ``squared_errors`` (H, W): means of the pixels' own samples and their squared standard errors, averaged
    over colours; ``count`` (H, W): samples. The edge of a lamp, which few samples of a pixel see, is certain with its
    lamp.
    """
    mean, error = blurred(grey, 1 / 3), blurred(squared_errors, 1 / 3)  # over 3 x 3 pixels
    mask: Mask = (count >= LEAST_COUNT) & (9.0 * np.square(mean) >= CERTAIN**2 * error)
    return mask


def find_glare(brightness: Singles, certain: Mask, bright: float) -> Mask:
    """Return which pixels (H, W) of a picture of this ``brightness`` (H, W) are glaring or beside glare.

    ``certain`` (H, W): what ``is_certain`` returned; other pixels are no glare. ``bright``: brightness of
    the brighter pixels of the whole picture.
    """
    surface = np.maximum(blurred(brightness, SIDE_TAP), np.float32(DARKEST * max(bright, 0.0) + 1e-20))
    sure = np.where(certain, brightness, np.float32(0))
    mask: Mask = sure > GLARING * extreme(surface, AROUND, np.minimum)
    for side, contrast in CONTRASTS.items():
        mask |= extreme(sure, side, np.maximum) > contrast * surface
    return mask
