"""What criteria that look at colours have in common; this module holds no criterion.

A film of one channel is taken as grey. The channels of a film that holds X, Y, Z are taken as if they were R, G, B:
what a criterion is given does not say which they are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Floats
from tracer.criteria.registry import Evidence
from tracer.film.estimate import Statistics
from tracer.image.colour import luminance

if TYPE_CHECKING:
    import mitsuba as mi

Sums: TypeAlias = "tuple[list[mi.Float], list[mi.Float]]"
"""Quantities of a sample whose mean over a pixel a criterion asks for, and quantities whose maximum it asks for."""

ROUNDING = 2.0**-24
"""Relative rounding error of one addition in float32."""


def known(evidence: Evidence) -> Statistics:
    """Return the statistics of ``evidence``, for criteria that are called only when there are statistics."""
    assert evidence.statistics is not None
    return evidence.statistics


def colours(values: NDArray, channels: int, group: int = 0) -> Floats:
    """Return group ``group``, from 0, of ``channels`` channels of values (H, W, K), as float64 (H, W, channels)."""
    return values[..., group * channels : (group + 1) * channels].astype(np.float64)


def divided(numerator: Floats, denominator: Floats) -> Floats:
    """Return a quotient (any shape); 0 where the denominator is not positive."""
    return np.divide(numerator, denominator, out=np.zeros_like(numerator), where=denominator > 0)


def mean_colour(evidence: Evidence) -> Floats:
    """Return the mean of each colour channel (H, W, C), with negative means as 0."""
    return np.maximum(colours(known(evidence).mean, evidence.colour_channels), 0.0)


def grey_as_rgb(values: Floats) -> Floats:
    """Return colours (H, W, 3) from (H, W, 3) or (H, W, 1)."""
    return values if values.shape[-1] == 3 else values.repeat(3, axis=-1)


def perceived(evidence: Evidence, measure: Floats) -> Floats:
    """Return sum_k w_k m_k c_k / sum_k w_k (H, W) of a measure m (H, W, C), with mean colour c and luminance weights w.

    Equation 8 of J. Rigau, M. Feixas and M. Sbert, "Entropy-based adaptive sampling", Graphics Interface 2003: without
    the mean colour, noise too dark to be seen would be refined most.
    """
    return luminance(measure * mean_colour(evidence))


def beyond_rounding(measure: Floats, evidence: Evidence, scale: Floats | float = 1.0) -> Floats:
    """Return a measure (H, W, C), set to 0 where it is no more than the rounding error of the sums behind it.

    The measure is a difference of terms of the order of ``scale``, from sums of n numbers in float32. Otherwise bright
    pixels without noise would seem to have some, and a root would make it large.
    """
    count = known(evidence).count[..., None].astype(np.float64)
    return np.where(measure > ROUNDING * (count + 16.0) * scale, measure, 0.0)


def ranked(error: Floats, evidence: Evidence, least: int = 2) -> Floats:
    """Return an error (H, W) as importance: finite, >= 0, and the largest of all where the error is not known yet.

    It is not known where a pixel has fewer than ``least`` samples, or samples that exceed what float32 can hold.
    """
    measured = np.isfinite(error) & (known(evidence).count >= least)
    largest = float(error.max(where=measured, initial=0.0))
    return np.where(measured, np.maximum(error, 0.0), largest if largest > 0 else 1.0)
