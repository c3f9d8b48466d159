"""Sums over the samples of consecutive pixels, of which an estimate consists.

Each lane walks through the samples of one pixel in order. So no two lanes write to the same place, and the division of
a picture into passes cannot change the sums. A band is small enough that adding to it, which copies it, takes little
memory.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi

from tracer.sampling.samples import Samples
from tracer.sampling.wavefront import Window

BAND_PIXELS = 1 << 16
"""Number of pixels of each band but the last, which may have fewer."""
Tree = Any
"""A device array, or nested lists of device arrays."""
FilterWeights = Callable[[Any], list[Any]]
"""Function from a position within the pixel (mi.Point2f) to the filter's weights in each pixel of the footprint."""


class Band:
    """Running sums of ``size`` pixels from ``first``: float64 mean and squared deviation (Welford), float32 footprint.

    The footprint of a pixel is what its samples give to every pixel in reach of the filter. For a filter without reach
    (box filter) there is none, as it would equal the mean.
    """

    def __init__(self, first: int, size: int, channels: int, offsets: int, moments: int = 0, peaks: int = 0) -> None:
        self.first, self.size = first, size
        self.count = dr.zeros(mi.UInt32, size)
        self.invalid = dr.zeros(mi.UInt32, size)
        self.mean = [dr.zeros(mi.Float64, size) for _ in range(channels)]
        self.deviation = [dr.zeros(mi.Float64, size) for _ in range(channels)]
        self.footprint = [[dr.zeros(mi.Float, size) for _ in range(channels + 1)] for _ in range(offsets)]
        """For each offset (row by row): sums of weight x channel for every channel, then the sum of weights."""
        self.extra = [dr.zeros(mi.Float, size) for _ in range(1 + moments)]
        """Sum of rays, then the sums of the moments that a criterion asked for."""
        self.peaks = [dr.full(mi.Float, -dr.inf, size) for _ in range(peaks)]

    @property
    def sums(self) -> list[Tree]:
        """All arrays, as nested lists."""
        return [self.count, self.invalid, self.mean, self.deviation, self.footprint, self.extra, self.peaks]

    @sums.setter
    def sums(self, arrays: list[Tree]) -> None:
        self.count, self.invalid, self.mean, self.deviation, self.footprint, self.extra, self.peaks = arrays

    def add(self, window: Window, samples: Samples, filter_weights: FilterWeights) -> None:
        """Add the samples of a pass that belong to the band's pixels."""
        begin, end = window.lanes_of(self.first, self.size)
        # The loop writes to the arrays that it is given; copies keep those of ``sums`` as they are.
        state = (mi.UInt32(begin), *copy(self.sums))
        _, *self.sums = dr.while_loop(
            state, lambda lane, *_: lane < end, lambda *arrays: step(samples, filter_weights, *arrays)
        )
        dr.eval(self.sums)

    def merge(self, other_band: Band) -> None:
        """Add the sums of other samples of the same pixels (T. Chan, G. Golub and R. LeVeque, 1979)."""
        own_count, other_count = mi.Float64(self.count), mi.Float64(other_band.count)
        total = own_count + other_count
        share = dr.select(total > 0, other_count / dr.maximum(total, 1), 0)
        difference = [b - a for a, b in zip(self.mean, other_band.mean, strict=True)]
        self.mean = [dr.fma(d, share, m) for d, m in zip(difference, self.mean, strict=True)]
        self.deviation = [
            a + b + d * d * own_count * share
            for d, a, b in zip(difference, self.deviation, other_band.deviation, strict=True)
        ]
        self.count += other_band.count
        self.invalid += other_band.invalid
        self.footprint = [
            [a + b for a, b in zip(own_sums, other_sums, strict=True)]
            for own_sums, other_sums in zip(self.footprint, other_band.footprint, strict=True)
        ]
        self.extra = [a + b for a, b in zip(self.extra, other_band.extra, strict=True)]
        self.peaks = [dr.maximum(a, b) for a, b in zip(self.peaks, other_band.peaks, strict=True)]
        dr.eval(self.sums)


def step(
    samples: Samples,
    filter_weights: FilterWeights,
    lane: Any,
    count: Any,
    invalid: Any,
    mean: list,
    deviation: list,
    footprint: list,
    extra: list,
    peaks: list,
) -> tuple:
    """Return the state of the walk after sample ``lane``. A sample that is not finite in every channel is left out."""
    values = [dr.gather(mi.Float, channel, lane) for channel in samples.values]
    finite = mi.Bool(True)
    for value in values:
        finite &= dr.isfinite(value)
    values = [dr.select(finite, value, 0.0) for value in values]
    count = count + dr.select(finite, mi.UInt32(1), mi.UInt32(0))
    invalid = invalid + dr.select(finite, mi.UInt32(0), mi.UInt32(1))
    # Welford (1962): one pass, no cancellation
    share = dr.select(finite, 1.0 / mi.Float64(count), 0.0)
    difference = [mi.Float64(value) - m for value, m in zip(values, mean, strict=True)]
    mean = [m + d * share for m, d in zip(mean, difference, strict=True)]
    deviation = [
        q + dr.select(finite, d * (mi.Float64(value) - m), 0.0)
        for q, d, value, m in zip(deviation, difference, values, mean, strict=True)
    ]
    added = []
    if footprint:
        position = dr.gather(mi.Point2f, samples.position, lane)
        for arrays, weight in zip(footprint, filter_weights(position), strict=True):
            weight = dr.select(finite, weight, 0.0)
            added.append([dr.fma(weight, v, s) for v, s in zip([*values, mi.Float(1.0)], arrays, strict=True)])
    arrays = [dr.gather(mi.Float, quantity, lane) for quantity in (samples.rays, *samples.moments)]
    extra = [total + dr.select(finite, quantity, 0.0) for total, quantity in zip(extra, arrays, strict=True)]
    arrays = [dr.gather(mi.Float, quantity, lane) for quantity in samples.peaks]
    peaks = [dr.select(finite, dr.maximum(peak, quantity), peak) for peak, quantity in zip(peaks, arrays, strict=True)]
    return lane + 1, count, invalid, mean, deviation, added, extra, peaks


def bands(pixel_count: int, *sums: int) -> list[Band]:
    """Return bands that cover ``pixel_count`` pixels; ``sums``: numbers of channels, offsets and so on for ``Band``."""
    return [Band(first, min(BAND_PIXELS, pixel_count - first), *sums) for first in range(0, pixel_count, BAND_PIXELS)]


def copy(tree: Tree) -> Tree:
    """Return nested lists like ``tree`` with a new variable of the same value for every array."""
    return [copy(entry) for entry in tree] if isinstance(tree, list) else type(tree)(tree)
