"""What criteria that look at colours have in common; no criterion itself.

A film of one channel is taken as grey. Of films that hold X, Y, Z the channels are taken as they are: what a criterion
is given does not say which they are.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.criteria.registry import Evidence
from tracer.film.estimate import Statistics
from tracer.image.colour import luminance

Sums = tuple[list[Any], list[Any]]
"""What a criterion asks to be averaged over the samples of a pixel, and what it asks the maximum of."""

ROUNDING = 2.0**-24
"""Of one float32 addition, relative."""


def known(evidence: Evidence) -> Statistics:
    """Return the statistics of a criterion that is never asked without."""
    assert evidence.statistics is not None
    return evidence.statistics


def colours(values: NDArray, channels: int, group: int = 0) -> Floats:
    """Return ``channels`` of values (H, W, K), those of ``group``, as (H, W, channels) of float64."""
    return values[..., group * channels : (group + 1) * channels].astype(np.float64)


def divided(numerator: Floats, denominator: Floats) -> Floats:
    """Return a quotient, 0 where the denominator is not positive."""
    return np.divide(numerator, denominator, out=np.zeros_like(numerator), where=denominator > 0)


def mean_colour(evidence: Evidence) -> Floats:
    """Return the mean of each colour channel (H, W, C), negative ones as 0."""
    return np.maximum(colours(known(evidence).mean, evidence.colour_channels), 0.0)


def grey_as_rgb(values: Floats) -> Floats:
    """Return colours (H, W, 3) from (H, W, 3) or (H, W, 1)."""
    return values if values.shape[-1] == 3 else values.repeat(3, axis=-1)


def perceived(evidence: Evidence, measure: Floats) -> Floats:
    """Return sum_k w_k m_k c_k / sum_k w_k of a measure m (H, W, C), c the mean colour and w the weights of luminance.

    Equation 8 of J. Rigau, M. Feixas and M. Sbert, "Entropy-based adaptive sampling", Graphics Interface 2003: without
    the mean colour, noise too dark to be seen would be refined most.
    """
    return luminance(measure * mean_colour(evidence))


def beyond_rounding(measure: Floats, evidence: Evidence, scale: Floats | float = 1.0) -> Floats:
    """Return a measure (H, W, C) >= 0, made 0 where it is no more than the rounding of the sums it is made of.

    It is a difference of terms of the order of ``scale``, from sums of n float32. Pixels without noise would otherwise
    have some where they are bright, and a root of it would make it large.
    """
    count = known(evidence).count[..., None].astype(np.float64)
    return np.where(measure > ROUNDING * (count + 16.0) * scale, measure, 0.0)


def ranked(error: Floats, evidence: Evidence, least: int = 2) -> Floats:
    """Return an error (H, W) as importance: finite, >= 0, and the largest where nothing can be known yet.

    That is where a pixel has fewer than ``least`` samples, or such as are beyond what float32 can hold.
    """
    measured = np.isfinite(error) & (known(evidence).count >= least)
    most = float(error.max(where=measured, initial=0.0))
    return np.where(measured, np.maximum(error, 0.0), most if most > 0 else 1.0)
