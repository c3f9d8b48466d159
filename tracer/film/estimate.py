"""Mean, variance and count per pixel, and the image through any reconstruction filter.

Samples are not scattered to neighbouring pixels. Each pixel sums what its own samples would give to every pixel in
reach of the filter, its *footprint*; see ``tracer.film.reconstruction``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from tracer.core.arrays import Singles
from tracer.core.device import interleave, numpy_kind, to_host, upload
from tracer.film.pixel_sums import Tree, cut_into_bands, footprint_length, whole
from tracer.film.reconstruction import reconstruct
from tracer.sampling.samples import Samples
from tracer.sampling.wavefront import Window
from tracer.sampling.work import work_of
from tracer.scene.frame import Frame
from tracer.scene.view import View


@dataclass(frozen=True)
class Statistics:
    """What is known of each pixel of the grid, through a box filter: samples of a pixel count for that pixel alone.

    C is the number of channels, colours first, linear. ``tracer.criteria.Evidence`` has an example.
    """

    count: NDArray[np.uint32]
    """(H, W): number of finite samples."""
    invalid: NDArray[np.uint32]
    """(H, W): number of samples that were not finite and are left out."""
    mean: Singles
    """(H, W, C): mean of the finite samples; 0 where there is none."""
    variance: Singles
    """(H, W, C): unbiased variance of one sample; 0 where there are fewer than two."""
    work: Singles
    """(H, W): mean of what a pixel's samples cost, in the unit of ``tracer.sampling.work``; 0 where there is none."""
    moments: Singles
    """(H, W, K): means of the moments that a criterion asked for."""
    peaks: Singles
    """(H, W, K): maxima of the quantities that a criterion asked for; -inf where there is no sample."""


class Estimate:
    """Running estimate over ``view.grid``, in bands of pixels."""

    def __init__(self, view: Frame, moments: int = 0, peaks: int = 0, rfilter: Any = None) -> None:
        """``moments`` and ``peaks``: how many of these ``Samples`` have. ``rfilter``: the film's reconstruction filter,
        without which no samples can be added; None: that of the view, if ``view`` is a ``View``.
        """
        self.view = view
        self.moments, self.peaks = moments, peaks
        self.filter: Any = view.film.rfilter() if rfilter is None and isinstance(view, View) else rfilter
        self.reach = view.reach
        channels = len(view.channels)
        self.bands = cut_into_bands(view.pixel_count, channels, footprint_length(self.reach, channels), moments, peaks)

    def filter_weights(self, position: Any) -> list[Any]:
        """Return the weights (mi.Float each) of samples at ``position`` in each pixel in reach, row by row."""
        centres = [offset + 0.5 for offset in range(-self.reach, self.reach + 1)]
        across = [self.filter.eval(centre - position.x) for centre in centres]
        down = [self.filter.eval(centre - position.y) for centre in centres]
        return [y * x for y in down for x in across]

    def add(self, window: Window, samples: Samples) -> None:
        """Add the samples of a pass. Samples that are not finite in every channel are counted and left out."""
        samples = replace(samples, moments=[work_of(samples.vertices), *samples.moments])
        for band in self.bands:
            if window.touches(band.first, band.size):
                band.add(window, samples, self.filter_weights)

    def merge(self, other_estimate: Estimate) -> None:
        """Add an estimate of the same view from other samples. The order of merging affects only rounding."""
        for band, other_band in zip(self.bands, other_estimate.bands, strict=True):
            band.merge(other_band)

    @property
    def count(self) -> Any:
        """Number of samples of each pixel (mi.UInt32), without those that were not finite."""
        return whole(self.bands, "count")

    def samples(self) -> NDArray[np.uint32]:
        """Return the number of samples of each pixel of the image (H, W), without those that were not finite."""
        return to_host(self.count, self.view.grid)[self.view.inner]

    def drawn(self) -> NDArray[np.uint32]:
        """Return the number of samples of each pixel (grid), those not finite too: the index of its next sample."""
        return to_host(self.count + whole(self.bands, "invalid"), self.view.grid)

    def here(self) -> Estimate:
        """Return this estimate: all of its sums are in this process already."""
        return self

    def state(self) -> list[NDArray]:
        """Return all sums as NumPy arrays, (P,) or (P, K), for another process to ``restore``."""
        pieces = zip(*(leaves(band.sums) for band in self.bands), strict=True)
        shapes = shapes_of_sums(self.view, self.moments, self.peaks)
        return [
            self.layout,
            *(
                np.concatenate([piece.numpy() for piece in arrays]).reshape(shape)
                for arrays, shape in zip(pieces, shapes, strict=True)
            ),
        ]

    def blank(self) -> list[NDArray]:
        """Return arrays like those of ``state`` for an estimate without samples, without work on the device."""
        kinds = [numpy_kind(array) for array in leaves(self.bands[0].sums)]
        shapes = shapes_of_sums(self.view, self.moments, self.peaks)
        arrays = [np.zeros(shape, kind) for shape, kind in zip(shapes, kinds, strict=True)]
        for peaks in arrays[len(arrays) - self.peaks :]:
            peaks[...] = -np.inf
        return [self.layout, *arrays]

    def restore(self, state: list[NDArray]) -> None:
        """Take over sums that ``state`` returned in another process. Raises ValueError for those of another view."""
        require_sums_of(self.view, self.moments, self.peaks, state)
        for band in self.bands:
            pieces = iter([array[band.first : band.first + band.size] for array in state[1:]])
            band.sums = [rebuilt(tree, pieces) for tree in band.sums]

    @property
    def layout(self) -> NDArray[np.int64]:
        """Size of the grid, then numbers of channels, reach, moments and peaks: equal in estimates that can merge."""
        return layout_of(self.view, self.moments, self.peaks)

    def statistics(self) -> Statistics:
        """Return what is known so far, as arrays on the host."""
        grid, channels = self.view.grid, len(self.view.channels)
        sizes = channels, channels, 1 + self.moments, self.peaks
        arrays = [dr.empty(mi.Float, size * self.view.pixel_count) for size in sizes]
        for band in self.bands:
            per_degree = dr.rcp(mi.Float64(dr.maximum(band.count, 2) - 1))
            per_sample = dr.rcp(mi.Float(dr.maximum(band.count, 1)))
            variances = [squares * per_degree for squares in band.deviation]
            means = [total * per_sample for total in band.extra]
            pixel = dr.arange(mi.UInt32, band.size) + dr.opaque(mi.UInt32, band.first)
            for array, channel_values in zip(arrays, (band.mean, variances, means, band.peaks), strict=True):
                interleave(array, channel_values, pixel)
            dr.eval(arrays)
        mean, variance, extra, peaks = (
            to_host(array, (*grid, size)) for array, size in zip(arrays, sizes, strict=True)
        )
        return Statistics(
            count=to_host(whole(self.bands, "count"), grid),
            invalid=to_host(whole(self.bands, "invalid"), grid),
            mean=mean,
            variance=variance,
            work=extra[..., 0].copy(),
            moments=extra[..., 1:].copy(),
            peaks=peaks,
        )

    def develop(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the image (H, W, C) and the standard error of each of its values, both without the border."""
        return reconstruct(self.bands, self.view)


def layout_of(frame: Frame, moments: int, peaks: int) -> NDArray[np.int64]:
    """Return the layout of an estimate of a frame, see ``Estimate.layout``."""
    return np.array([*frame.grid, len(frame.channels), frame.reach, moments, peaks])


def shapes_of_sums(frame: Frame, moments: int, peaks: int) -> list[tuple[int, ...]]:
    """Return the shapes of the arrays of a state, but for the layout: (P,), or (P, K) for the footprint."""
    pixel_count, channels = frame.pixel_count, len(frame.channels)
    length = footprint_length(frame.reach, channels)
    footprint: list[tuple[int, ...]] = [(pixel_count, length)] if length else []
    return [(pixel_count,)] * (2 + 2 * channels) + footprint + [(pixel_count,)] * (1 + moments + peaks)


def require_sums_of(frame: Frame, moments: int, peaks: int, state: list[NDArray]) -> None:
    """Raise ValueError if arrays are not a state of an estimate of the frame."""
    # The numbers may come from a damaged file: nothing may be made of them before they are known to fit.
    if not state or not np.array_equal(state[0], layout_of(frame, moments, peaks)) or moments + peaks > len(state):
        raise ValueError("these sums are of another view")
    shapes = shapes_of_sums(frame, moments, peaks)
    if len(state) != 1 + len(shapes):
        raise ValueError("these sums are of another view")
    if [array.shape for array in state[1:]] != shapes:
        raise ValueError("these sums are of another number of pixels")


def leaves(tree: Tree) -> list[Any]:
    """Return the arrays within nested lists, in order."""
    return [leaf for entry in tree for leaf in leaves(entry)] if isinstance(tree, list) else [tree]


def rebuilt(tree: Tree, arrays: Iterator[NDArray]) -> Tree:
    """Return nested lists like ``tree``, with the next of ``arrays``, uploaded, in place of its arrays."""
    if isinstance(tree, list):
        return [rebuilt(entry, arrays) for entry in tree]
    return upload(type(tree), next(arrays))
