"""Mean, variance and count per pixel, and the image through any reconstruction filter.

A sample does not scatter to its neighbours. Each pixel sums what its own samples would give to every pixel in reach of
the filter, its *footprint*; only when the image is developed are these sums divided by the pixel's final count and
added up: the expected image is the one of ``mi.render`` for every filter, and equal to it when all counts are equal.
However unequal the counts, dense pixels do not bleed into sparse ones; and as each lane walks through the samples of
one pixel in order, no two lanes write to one place and the split into passes cannot change the statistics.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from math import ceil
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.draw import Samples, Window, divide
from tracer.scene import View

Floats = NDArray[np.float64]
Tree = Any
"""A device array, or nested lists of them."""
DENSE = 4
"""A pass that touches one pixel in so many walks over all of them: reading and writing whole arrays in order is many
times faster than gathering and scattering."""


@dataclass(frozen=True)
class Statistics:
    """What is known of each pixel of the grid, box-filtered: samples of a pixel count for that pixel alone."""

    count: NDArray[np.uint32]
    """(H, W): finite samples."""
    invalid: NDArray[np.uint32]
    """(H, W): samples that were not finite and are left out."""
    mean: Floats
    """(H, W, C)."""
    variance: Floats
    """(H, W, C): unbiased variance of one sample; 0 where there are fewer than two."""


class Estimate:
    """Running estimate over ``view.grid``: float64 mean and squared deviation (Welford), float32 footprint sums."""

    def __init__(self, view: View) -> None:
        self.view = view
        self.filter = view.film.rfilter()
        self.reach = 0 if self.filter.is_box_filter() else ceil(self.filter.radius() - 0.5)
        pixels, channels = view.pixel_count, len(view.channels)
        self.count = dr.zeros(mi.UInt32, pixels)
        self.invalid = dr.zeros(mi.UInt32, pixels)
        self.mean = [dr.zeros(mi.Float64, pixels) for _ in range(channels)]
        self.deviation = [dr.zeros(mi.Float64, pixels) for _ in range(channels)]
        offsets = (2 * self.reach + 1) ** 2
        self.footprint = [[dr.zeros(mi.Float, pixels) for _ in range(channels + 1)] for _ in range(offsets)]
        """Per offset (row by row): sums of weight x channel, then of weight."""

    def filter_weights(self, position: Any) -> list[Any]:
        """Return the weight of a sample at ``position`` for each pixel in reach, offsets row by row."""
        if self.reach == 0:
            return [mi.Float(1.0)]
        centres = [offset + 0.5 for offset in range(-self.reach, self.reach + 1)]
        across = [self.filter.eval(centre - position.x) for centre in centres]
        down = [self.filter.eval(centre - position.y) for centre in centres]
        return [y * x for y in down for x in across]

    def add(self, window: Window, samples: Samples) -> None:
        """Add the samples of a pass. Samples that are not finite in every channel are counted and left out."""
        sums: Tree = [self.count, self.invalid, self.mean, self.deviation, self.footprint]
        if dr.width(window.begin) * DENSE < self.view.pixel_count:
            pixel = dr.arange(mi.UInt32, dr.width(window.begin)) + dr.opaque(mi.UInt32, window.first_pixel)
            added = self.walk([gather(each, pixel) for each in sums], window.begin, window.end, samples)
            for target, value in zip(leaves(sums), leaves(added), strict=True):
                dr.scatter(target, value, pixel, mode=dr.ReduceMode.NoConflicts)
        else:
            begin, end = (window.over(self.view.pixel_count, lanes) for lanes in (window.begin, window.end))
            added = self.walk(sums, begin, end, samples)
            self.count, self.invalid, self.mean, self.deviation, self.footprint = added
        dr.eval(self.count, self.invalid, self.mean, self.deviation, self.footprint)

    def walk(self, sums: Tree, begin: Any, end: Any, samples: Samples) -> Tree:
        """Return ``sums`` of some pixels with samples ``begin`` to ``end`` (one entry a pixel) added in order."""

        def step(lane: Any, count: Any, invalid: Any, mean: list, deviation: list, footprint: list) -> tuple:
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
            position = dr.gather(mi.Point2f, samples.position, lane)
            added = []
            for own, weight in zip(footprint, self.filter_weights(position), strict=True):
                weight = dr.select(finite, weight, 0.0)
                added.append([dr.fma(weight, v, s) for v, s in zip([*values, mi.Float(1.0)], own, strict=True)])
            return lane + 1, count, invalid, mean, deviation, added

        # The loop writes to what it is given; copies keep the arrays of ``sums`` as they are.
        _, *added = dr.while_loop((mi.UInt32(begin), *copy(sums)), lambda lane, *_: lane < end, step)
        return added

    def statistics(self) -> Statistics:
        """Return what is known so far, on the host."""
        shape = self.view.grid
        count = to_host(self.count, shape)
        mean = np.stack([to_host(channel, shape) for channel in self.mean], axis=-1)
        deviation = np.stack([to_host(channel, shape) for channel in self.deviation], axis=-1)
        variance = deviation / np.maximum(count[..., None].astype(np.int64) - 1, 1)
        return Statistics(count, to_host(self.invalid, shape), mean, variance)

    def develop(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the image (H, W, C) and the standard error of each of its values, both without the border.

        Image: sum over pixels i in reach of A_i / n_i, divided by the same sum of B_i / n_i, with A and B the sums of
        weight x channel and of weight over the n_i samples of i. Its variance is the sum of s_i^2 / n_i times the
        square of the share that i has in the image's pixel; pixels i with fewer than two samples add nothing to it.
        """
        (grid_height, grid_width), border = self.view.grid, self.view.border
        row, column = divide(dr.arange(mi.UInt32, self.view.size[0] * self.view.size[1]), self.view.size[1])
        corner = mi.Point2i(mi.Int32(column), mi.Int32(row)) + border
        channels = len(self.mean)
        total, variance = ([mi.Float(0) for _ in range(channels)] for _ in range(2))
        weight = mi.Float(0)
        offsets = itertools.product(range(-self.reach, self.reach + 1), repeat=2)
        for (down, right), sums in zip(offsets, self.footprint, strict=True):
            source = corner - mi.ScalarPoint2i(right, down)
            inside = (source.x >= 0) & (source.y >= 0) & (source.x < grid_width) & (source.y < grid_height)
            pixel = mi.UInt32(source.y * grid_width + source.x)
            count = mi.Float(dr.gather(mi.UInt32, self.count, pixel, inside))
            per_sample = dr.select(count > 0, dr.rcp(count), 0)
            per_degree = dr.select(count > 1, dr.rcp(count - 1), 0)
            share = dr.gather(mi.Float, sums[-1], pixel, inside) * per_sample
            weight += share
            for channel in range(channels):
                total[channel] += dr.gather(mi.Float, sums[channel], pixel, inside) * per_sample
                deviation = mi.Float(dr.gather(mi.Float64, self.deviation[channel], pixel, inside))
                variance[channel] += dr.square(share) * deviation * per_degree * per_sample
        scale = dr.select(weight == 0, 0, dr.rcp(weight))
        image, stderr = [channel * scale for channel in total], [dr.sqrt(v) * dr.abs(scale) for v in variance]
        dr.eval(image, stderr)
        return to_image(image, self.view.size), to_image(stderr, self.view.size)


def gather(tree: Tree, pixel: Any) -> Tree:
    """Gather every array of nested lists at ``pixel``."""
    return [gather(entry, pixel) for entry in tree] if isinstance(tree, list) else dr.gather(type(tree), tree, pixel)


def copy(tree: Tree) -> Tree:
    """Return new variables with the values of every array of nested lists."""
    return [copy(entry) for entry in tree] if isinstance(tree, list) else type(tree)(tree)


def leaves(tree: Tree) -> list[Any]:
    """Return the arrays of nested lists, in order."""
    return [leaf for entry in tree for leaf in leaves(entry)] if isinstance(tree, list) else [tree]


def to_host(array: Any, shape: tuple[int, int]) -> NDArray:
    """Return a device array as NumPy, in the shape of the grid."""
    return np.asarray(array.numpy()).reshape(shape)


def to_image(channels: list[Any], size: tuple[int, int]) -> NDArray[np.float32]:
    """Return device arrays, one a channel, as one NumPy array (H, W, C)."""
    return np.stack([to_host(channel, size) for channel in channels], axis=-1)
