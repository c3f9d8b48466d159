"""The image through any reconstruction filter, from the sums of pixels, and its standard error.

Each pixel has summed what its own samples give to every pixel in reach of the filter, its *footprint*. Only here are
these sums divided by the pixel's final count and added up. For every filter the expected image is that of
``mi.render``, and the image is equal to it if all counts are equal. However unequal the counts are, pixels with many
samples do not bleed into pixels with few.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.device import divide, interleave, to_host
from tracer.film.pixel_sums import AT_ONCE, Band, from_packets, in_packets, whole
from tracer.scene.frame import Frame

PRIOR_RADIUS, PRIOR_DEGREES = 3, 16.0
"""PRIOR_RADIUS: pixels on each side of the window around a pixel whose variance is the prior of the pixel's variance.
PRIOR_DEGREES: degrees of freedom for which that prior counts. With 7 x 7 pixels and 16 degrees the true error of the
bundled scenes is 0.4 to 1.4 standard errors (RMS), most where light is rare."""


@dataclass(frozen=True)
class Rows:
    """Several numbers of each pixel, side by side."""

    array: Any
    """mi.Float: the row of pixel 0, then that of pixel 1, ..."""
    length: int
    """Entries of a row, a multiple of AT_ONCE."""

    @classmethod
    def of(cls, columns: list[Any]) -> Rows:
        """Return rows of the values of pixels, one mi.Float for each of ``columns``; zeros fill the last packet."""
        size, packet_count = dr.width(columns[0]), -(-len(columns) // AT_ONCE)
        padding = [mi.Float(0)] * (AT_ONCE * packet_count - len(columns))
        array = from_packets(in_packets([*columns, *padding]), size)
        dr.eval(array)
        return cls(array, AT_ONCE * packet_count)

    def entries(self, pixel: Any, begin: int, count: int, active: Any) -> list[Any]:
        """Return ``count`` entries from ``begin`` on of the rows of pixels (mi.UInt32), a list of mi.Float."""
        first, end = begin // AT_ONCE, -(-(begin + count) // AT_ONCE)
        start = pixel * (self.length // AT_ONCE)
        packets = [dr.gather(mi.Vector4f, self.array, start + k, active) for k in range(first, end)]
        return [entry for packet in packets for entry in packet][begin - AT_ONCE * first :][:count]


def reconstruct(bands: list[Band], frame: Frame) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the image (H, W, C) and the standard error of each of its values, both without the border of the grid.

    The image is the sum over pixels i in reach of A_i / n_i, divided by the same sum of B_i / n_i; A_i and B_i are the
    sums of weight x channel and of weight over the n_i samples of i. Its variance is the sum of s_i^2 / n_i times the
    square of the share that i has in the image's pixel, with s_i^2 from ``shrunken_variance``.
    """
    known = scales_and_errors(bands, frame)
    shape = *frame.size, len(frame.channels)
    image, stderr = (dr.empty(mi.Float, math.prod(shape)) for _ in range(2))
    for number in range(len(bands)):
        develop_band(bands, number, frame, known, image, stderr)
    return to_host(image, shape), to_host(stderr, shape)


def scales_and_errors(bands: list[Band], frame: Frame) -> Rows:
    """Return for each pixel the reciprocal of its count and, by channel, the squared standard error of its mean."""
    count = mi.Float64(whole(bands, "count"))
    per_sample = mi.Float(dr.select(count > 0, dr.rcp(count), 0))
    deviation = [whole(bands, "deviation", c) for c in range(len(frame.channels))]
    variances = shrunken_variance(deviation, count, frame.grid)
    return Rows.of([per_sample, *(variance * per_sample for variance in variances)])


def develop_band(bands: list[Band], number: int, frame: Frame, known: Rows, image: Any, stderr: Any) -> None:
    """Write the pixels of a band into ``image`` and ``stderr`` (mi.Float), pixel after pixel.

    ``known``: see ``scales_and_errors``.
    """
    band = bands[number]
    pixel = dr.arange(mi.UInt32, band.size) + dr.opaque(mi.UInt32, band.first)
    if frame.reach == 0:
        _, *squared_errors = known.entries(pixel, 0, len(frame.channels) + 1, True)
        values, errors = band.mean, [dr.sqrt(squared_error) for squared_error in squared_errors]
    else:
        first, footprints = footprints_around(bands, number, frame)
        values, errors = filtered(Rows(footprints, band.footprint_length), first, pixel, known, frame)
    place, is_inside = place_in_image(pixel, frame)
    interleave(image, values, place, is_inside)
    interleave(stderr, errors, place, is_inside)
    dr.eval(image, stderr)


def filtered(footprints: Rows, first: int, pixel: Any, known: Rows, frame: Frame) -> tuple[list[Any], list[Any]]:
    """Return values and standard errors of pixels (mi.UInt32), each a list of mi.Float by channel.

    ``footprints``: those of all pixels in reach, and maybe of others, in order; ``first``: the first of these pixels.
    ``known``: see ``scales_and_errors``.
    """
    channels = range(len(frame.channels))
    row, column = (mi.Int32(index) for index in divide(pixel, frame.grid[1]))
    grid_height, grid_width = (dr.opaque(mi.Int32, side) for side in frame.grid)
    total, variance = ([mi.Float(0) for _ in channels] for _ in range(2))
    weight = mi.Float(0)
    first_pixel, sum_count = dr.opaque(mi.UInt32, first), len(channels) + 1
    for k, (down, right) in enumerate(itertools.product(range(-frame.reach, frame.reach + 1), repeat=2)):
        y, x = row - down, column - right
        inside = (x >= 0) & (y >= 0) & (x < grid_width) & (y < grid_height)
        source = mi.UInt32(y * grid_width + x)
        scale, *error = known.entries(source, 0, sum_count, inside)
        *sums, weight_sum = footprints.entries(source - first_pixel, k * sum_count, sum_count, inside)
        share = weight_sum * scale
        weight += share
        for c in channels:
            total[c] += sums[c] * scale
            variance[c] += dr.square(share) * error[c]
    per_weight = dr.select(weight == 0, 0, dr.rcp(weight))
    values = [channel * per_weight for channel in total]
    return values, [dr.sqrt(channel) * dr.abs(per_weight) for channel in variance]


def footprints_around(bands: list[Band], number: int, frame: Frame) -> tuple[int, Any]:
    """Return the first pixel in reach of a band, and the footprints of all up to the last one (mi.Float).

    They are copied, unless the picture has but one band.
    """
    band, margin = bands[number], frame.reach * (frame.grid[1] + 1)
    first, end = max(band.first - margin, 0), min(band.first + band.size + margin, frame.pixel_count)
    pieces = [
        piece.footprint_of(first, end) for piece in bands if piece.first < end and first < piece.first + piece.size
    ]
    return first, pieces[0] if len(pieces) == 1 else dr.concat(pieces)


def place_in_image(pixel: Any, frame: Frame) -> tuple[Any, Any]:
    """Return the places (mi.UInt32) of pixels of the grid in the image, row by row, and whether they are in it."""
    height, width, border = (dr.opaque(mi.Int32, number) for number in (*frame.size, frame.border))
    row, column = (mi.Int32(index) - border for index in divide(pixel, frame.grid[1]))
    is_inside = (row >= 0) & (column >= 0) & (row < height) & (column < width)
    return mi.UInt32(row * width + column), is_inside


def shrunken_variance(deviation: list[Any], count: Any, grid: tuple[int, int]) -> list[Any]:
    """Return the variance of one sample (mi.Float of all pixels, per channel) from squared deviations and counts.

    After few samples a pixel's own variance says too little: where light is found by chance, most pixels have not yet
    seen what makes them noisy. So it is averaged with the variance over a window around the pixel, which counts for
    PRIOR_DEGREES degrees of freedom (the posterior mean under an inverse-gamma prior). For quiet pixels beside noisy
    ones the result is too large.
    """
    degrees = dr.maximum(count - 1, 0)
    around = box_sum(degrees, grid)
    per_degree = dr.select(around > 0, dr.rcp(around), 0)
    per_sample = dr.rcp(PRIOR_DEGREES + degrees)
    return [
        mi.Float((PRIOR_DEGREES * per_degree * box_sum(channel, grid) + channel) * per_sample) for channel in deviation
    ]


def box_sum(values: Any, grid: tuple[int, int]) -> Any:
    """Return the sums of values (one per pixel) over windows of side 2 PRIOR_RADIUS + 1, with the edge repeated."""
    height, width = grid
    row, column = (mi.Int32(index) for index in divide(dr.arange(mi.UInt32, height * width), width))
    for down, right in ((0, 1), (1, 0)):
        total = dr.zeros(type(values), height * width)
        for offset in range(-PRIOR_RADIUS, PRIOR_RADIUS + 1):
            y = dr.clip(row + offset * down, 0, height - 1)
            x = dr.clip(column + offset * right, 0, width - 1)
            total += dr.gather(type(values), values, mi.UInt32(y * width + x))
        dr.eval(total)
        values = total
    return values
