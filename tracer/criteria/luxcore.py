"""LuxCoreRender's noise map: the change of the shown picture around a pixel is the chance of further samples.

The rule is that of ``filmnoiseestimation.cpp`` and the samplers of LuxCoreRender 2.10 (2025), with their defaults. The
change since the last look is sum_c |new_c - old_c| / sqrt(sum_c new_c) of the tone-mapped colours. It is averaged over
a window, turned into a standard score, cut off at 6 and scaled to 0 to 1 over the image. A pixel whose turn comes is
sampled with probability max(noise, 1 - strength), so further samples are in proportion to it: the rule never stops any
pixel. LuxCore looks every 32 samples per pixel, this criterion after every round; before the first comparison, all
pixels have the same importance.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter

from tracer.core.arrays import Floats
from tracer.criteria.colour import colours, divided, grey_as_rgb, known
from tracer.criteria.registry import Evidence, criterion
from tracer.film.estimate import Statistics

STRENGTH = 0.95
"""LuxCore's ``adaptive.strength``: at most, a pixel is 20 times as likely to be sampled as another."""
WINDOW = 8
"""Side of the window in pixels, from 4 before the pixel to 3 after it: LuxCore's loop with ``filter.scale`` 4."""
MOST = 6.0
"""Standard scores beyond this are outliers, and are cut off."""
GAMMA = 2.2
"""LuxCore's default gamma of the shown picture."""


def tone_mapped(statistics: Statistics, channels: int) -> Floats:
    """Return the mean colours (H, W, 3) as shown, 0 to 1, with exposure 1 and LuxCore's default gamma."""
    shown = grey_as_rgb(np.nan_to_num(colours(statistics.mean, channels)))
    return np.clip(shown, 0.0, 1.0) ** (1.0 / GAMMA)


def window_mean(values: Floats) -> Floats:
    """Return the mean (H, W) of ``values`` (H, W) over a window, of which only the part in the image counts."""
    inside = uniform_filter(np.ones_like(values), WINDOW, mode="constant")
    return uniform_filter(values, WINDOW, mode="constant") / inside


def noise(new: Floats, old: Floats) -> Floats:
    """Return the noise map (H, W), 0 to 1, of two tone-mapped pictures (H, W, 3); zeros if all pixels change alike."""
    change = window_mean(divided(np.abs(new - old).sum(axis=-1), np.sqrt(new.sum(axis=-1))))
    deviation = float(change.std())
    if deviation <= 1e-9 * float(change.mean()):  # rounding, not noise
        return np.zeros_like(change)
    score = np.clip((change - change.mean()) / deviation, -MOST, MOST)
    return (score - score.min()) / (score.max() - score.min())


@criterion("luxcore", needs_radiance=True, spends="more")
def luxcore(evidence: Evidence) -> Floats:
    """Return max(noise, 1 - STRENGTH) (H, W); ones as long as there is no earlier picture to compare with."""
    if evidence.before is None:
        return np.ones_like(evidence.weight)
    pictures = (tone_mapped(statistics, evidence.colour_channels) for statistics in (known(evidence), evidence.before))
    return np.maximum(noise(*pictures), 1.0 - STRENGTH)
