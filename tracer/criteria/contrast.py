"""Contrast between the brightest and the darkest sample of a pixel.

D. Mitchell, "Generating antialiased images at low sampling densities", SIGGRAPH 1987, compares
(Imax - Imin) / (Imax + Imin) of red, green and blue with a threshold for each; a single channel above its threshold is
enough to refine. Here all three thresholds are lowered together until the budget is spent. Mitchell took the samples
around a pixel; here they are those of the pixel. A black sample beside a lit one is full contrast, however dark both
are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tracer.core.arrays import Floats
from tracer.criteria.colour import Sums, colours, divided, grey_as_rgb, known, ranked
from tracer.criteria.registry import Evidence, criterion

if TYPE_CHECKING:
    import mitsuba as mi

THRESHOLDS = np.array([0.4, 0.3, 0.6])
"""Mitchell's thresholds for the contrast of red, green and blue."""


def extremes(colour: list[mi.Float], index: mi.UInt32) -> Sums:
    """Ask for the maxima of c and of -c per channel."""
    return [], [*colour, *(-c for c in colour)]


@criterion("contrast", needs_radiance=True, spends="priority", moments=extremes)
def contrast(evidence: Evidence) -> Floats:
    """Return the largest ratio of contrast to threshold over channels (H, W), 0 to 1 / 0.3."""
    channels, peaks = evidence.colour_channels, np.maximum(known(evidence).peaks, -np.finfo(np.float32).max)
    brightest = np.maximum(colours(peaks, channels), 0.0)
    darkest = np.maximum(-colours(peaks, channels, 1), 0.0)
    channel_contrast = divided(brightest - darkest, brightest + darkest)
    return ranked((grey_as_rgb(channel_contrast) / THRESHOLDS).max(axis=-1), evidence)
