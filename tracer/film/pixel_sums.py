"""Sums over the samples of consecutive pixels, of which an estimate consists.

Each lane walks through the samples of one pixel in order. So no two lanes write to the same place, and the division of
a picture into passes cannot change the sums. A band is small enough that adding to it, which copies it, takes little
memory. The many sums that the filter needs lie side by side for each pixel, so that one kernel can make a picture from
those of a pixel and its neighbours.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi

from tracer.sampling.samples import Samples
from tracer.sampling.wavefront import Window

BAND_PIXELS = 1 << 16
"""Number of pixels of each band but the last, which may have fewer."""
AT_ONCE = 4
"""Number of neighbouring entries of a footprint that are read and written at once: those of an mi.Vector4f."""
Tree = Any
"""A device array, or nested lists of device arrays."""
FilterWeights = Callable[[Any], list[Any]]
"""Function from a position within the pixel (mi.Point2f) to the filter's weights in each pixel of the footprint."""


class Band:
    """Running sums of ``size`` pixels from ``first``: float64 mean and squared deviation (Welford), float32 footprint.

    The footprint of a pixel is what its samples give to every pixel in reach of the filter. For a filter without reach
    (box filter) there is none, as it would equal the mean.
    """

    def __init__(
        self, first: int, size: int, channels: int, footprint_length: int, moments: int = 0, peaks: int = 0
    ) -> None:
        """``footprint_length``: see the function of that name."""
        self.first, self.size = first, size
        self.count = dr.zeros(mi.UInt32, size)
        self.invalid = dr.zeros(mi.UInt32, size)
        self.mean = [dr.zeros(mi.Float64, size) for _ in range(channels)]
        self.deviation = [dr.zeros(mi.Float64, size) for _ in range(channels)]
        self.footprint_length = footprint_length
        self.footprint = [dr.zeros(mi.Float, footprint_length * size)] if footprint_length else []
        """List of one array, pixel after pixel; an empty list for a filter without reach. For each offset (row by row):
        sums of weight x channel for every channel, then the sum of weights. Zeros at the end of each pixel's entries
        make them a multiple of AT_ONCE.
        """
        self.extra = [dr.zeros(mi.Float, size) for _ in range(1 + moments)]
        """Sum of work, then the sums of the moments that a criterion asked for."""
        self.peaks = [dr.full(mi.Float, -dr.inf, size) for _ in range(peaks)]

    @property
    def sums(self) -> list[Tree]:
        """All arrays, as nested lists."""
        return [self.count, self.invalid, self.mean, self.deviation, self.footprint, self.extra, self.peaks]

    @sums.setter
    def sums(self, arrays: list[Tree]) -> None:
        self.count, self.invalid, self.mean, self.deviation, self.footprint, self.extra, self.peaks = arrays

    def footprint_of(self, first: int, end: int) -> Any:
        """Return the footprints (mi.Float) of those of the band's pixels that are between ``first`` and ``end``."""
        (footprint,) = self.footprint
        begin, end = max(first - self.first, 0), min(end - self.first, self.size)
        if end - begin == self.size:
            return footprint
        entry = dr.arange(mi.UInt32, (end - begin) * self.footprint_length)
        entry += dr.opaque(mi.UInt32, begin * self.footprint_length)
        return dr.gather(mi.Float, footprint, entry)

    def add(self, window: Window, samples: Samples, filter_weights: FilterWeights) -> None:
        """Add the samples of a pass that belong to the band's pixels; the first of their moments is their work."""
        begin, end = window.lanes_of(self.first, self.size)
        # The loop writes to the arrays that it is given; copies keep those of ``sums`` as they are.
        count, invalid, mean, deviation, footprint, extra, peaks = copy(self.sums)
        packets = [packet for sums in footprint for packet in to_packets(sums, self.size)]
        _, *sums = dr.while_loop(
            (mi.UInt32(begin), count, invalid, mean, deviation, packets, extra, peaks),
            lambda lane, *_: lane < end,
            lambda *arrays: step(samples, filter_weights, *arrays),
        )
        self.count, self.invalid, self.mean, self.deviation, packets, self.extra, self.peaks = sums
        self.footprint = [from_packets(packets, self.size)] if packets else []
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
        self.footprint = [a + b for a, b in zip(self.footprint, other_band.footprint, strict=True)]
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
    packets: list,
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
    if packets:
        position = dr.gather(mi.Point2f, samples.position, lane)
        weights = [dr.select(finite, weight, 0.0) for weight in filter_weights(position)]
        factors = list(itertools.product(weights, [*values, mi.Float(1.0)]))
        sums = [entry for packet in packets for entry in packet]
        added = [dr.fma(*pair, entry) for pair, entry in zip(factors, sums[: len(factors)], strict=True)]
        packets = in_packets([*added, *sums[len(factors) :]])
    arrays = [dr.gather(mi.Float, quantity, lane) for quantity in samples.moments]
    extra = [total + dr.select(finite, quantity, 0.0) for total, quantity in zip(extra, arrays, strict=True)]
    arrays = [dr.gather(mi.Float, quantity, lane) for quantity in samples.peaks]
    peaks = [dr.select(finite, dr.maximum(peak, quantity), peak) for peak, quantity in zip(peaks, arrays, strict=True)]
    return lane + 1, count, invalid, mean, deviation, packets, extra, peaks


def footprint_length(reach: int, channels: int) -> int:
    """Return the number of entries of the footprint of a pixel; ``reach``: that of the filter in pixels.

    That is a sum for each channel, and the sum of weights, for each pixel in reach; then zeros up to a whole packet.
    There is no footprint if no other pixel is in reach.
    """
    return AT_ONCE * -(-((2 * reach + 1) ** 2) * (channels + 1) // AT_ONCE) if reach else 0


def to_packets(footprint: Any, size: int) -> list[Any]:
    """Return the footprint of ``size`` pixels (mi.Float) as a list of mi.Vector4f, each with one packet a pixel."""
    packet_count = dr.width(footprint) // (AT_ONCE * size)
    first = dr.arange(mi.UInt32, size) * packet_count
    return [dr.gather(mi.Vector4f, footprint, first + k) for k in range(packet_count)]


def from_packets(packets: list[Any], size: int) -> Any:
    """Return the footprint of ``size`` pixels (mi.Float) that consists of ``packets``."""
    footprint = dr.empty(mi.Float, AT_ONCE * len(packets) * size)
    first = dr.arange(mi.UInt32, size) * len(packets)
    for k, packet in enumerate(packets):
        # Without this mode, each of these writes would wait for the one before it and be a kernel of its own.
        dr.scatter(footprint, packet, first + k, mode=dr.ReduceMode.Permute)
    return footprint


def in_packets(entries: list[Any]) -> list[Any]:
    """Return arrays (mi.Float), a multiple of AT_ONCE in number, as packets of them."""
    return [mi.Vector4f(entries[k : k + AT_ONCE]) for k in range(0, len(entries), AT_ONCE)]


def cut_into_bands(pixel_count: int, *sums: int) -> list[Band]:
    """Return bands that cover ``pixel_count`` pixels; ``sums``: numbers of channels and so on for ``Band``."""
    return [Band(first, min(BAND_PIXELS, pixel_count - first), *sums) for first in range(0, pixel_count, BAND_PIXELS)]


def whole(bands: list[Band], name: str, *index: int) -> Any:
    """Return the sums called ``name`` of all bands as one array; ``index``: which of them, in a list of them."""
    parts = []
    for band in bands:
        part = getattr(band, name)
        for k in index:
            part = part[k]
        parts.append(part)
    return parts[0] if len(parts) == 1 else dr.concat(parts)


def copy(tree: Tree) -> Tree:
    """Return nested lists like ``tree`` with a new variable of the same value for every array."""
    return [copy(entry) for entry in tree] if isinstance(tree, list) else type(tree)(tree)
