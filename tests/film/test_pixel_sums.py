"""Sums of a band are those of a loop in NumPy, in one go or merged, whatever is not finite."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from tracer.film.pixel_sums import Band
from tracer.sampling.samples import Samples
from tracer.sampling.wavefront import Line, Stretch

CHANNELS, MOMENTS, PEAKS = 2, 2, 1
PADDING = [0, 0]
"""What makes the 2 x 3 sums of the footprint two packets of four."""


def filter_weights(position):
    return [position.x + 1, 2 * position.y]


def made_up(counts, seed):
    """Return values, positions, moments and peaks of so many samples, one after the other; some not finite."""
    random = np.random.default_rng(seed)
    number = int(counts.sum())
    values = random.lognormal(0, 1, (CHANNELS, number)).astype(np.float32)
    values[0, ::7], values[1, 3::11] = np.nan, np.inf
    position = random.random((2, number)).astype(np.float32)
    moments = random.random((1 + MOMENTS, number)).astype(np.float32)
    return values, position, moments, -random.random((PEAKS, number)).astype(np.float32)


def summed(before, counts, seed):
    """Return a band with the samples of ``made_up``."""
    values, position, moments, peaks = made_up(counts, seed)
    band = Band(0, len(counts), CHANNELS, 2 * (CHANNELS + 1) + len(PADDING), MOMENTS, PEAKS)
    window = Line(Stretch(0, before, before + counts)).take(int(counts.sum()))
    device = [[mi.Float(each) for each in several] for several in (values, moments, peaks)]
    band.add(window, Samples(device[0], mi.Point2f(position), mi.Float(1.0), *device[1:]), filter_weights)
    return band


def by_loop(*parts):
    """Return the same sums of all samples of each pixel of (counts, seed) in ``parts``."""
    drawn = [(np.repeat(np.arange(len(counts)), counts), *made_up(counts, seed)) for counts, seed in parts]
    pixel = np.concatenate([each[0] for each in drawn])
    values, position, moments, peaks = (
        np.concatenate([np.atleast_2d(each[k]) for each in drawn], axis=-1).astype(np.float64) for k in range(1, 5)
    )
    finite = np.isfinite(values).all(axis=0)
    sums = []
    for k in range(len(parts[0][0])):
        own = (pixel == k) & finite
        count = own.sum()
        mean = values[:, own].mean(axis=1) if count else np.zeros(CHANNELS)
        weights = np.stack([position[0, own] + 1, 2 * position[1, own]])
        footprint = [[*(values[:, own] * weight).sum(axis=1), weight.sum()] for weight in weights]
        sums.append(
            [
                count,
                ((pixel == k) & ~finite).sum(),
                *mean,
                *((values[:, own] - mean[:, None]) ** 2).sum(axis=1),
                *np.ravel(footprint),
                *PADDING,
                *moments[:, own].sum(axis=1),
                *peaks[:, own].max(axis=1, initial=-np.inf),
            ]
        )
    return np.array(sums).T


def leaves(tree, size):
    """Return the sums of ``size`` pixels, each (size,), and so those of the footprint one by one."""
    if isinstance(tree, list):
        return [leaf for entry in tree for leaf in leaves(entry, size)]
    return list(tree.numpy().reshape(size, -1).T)


def assert_same(band, expected):
    for sums, expected_sums in zip(leaves(band.sums, band.size), expected, strict=True):
        assert sums == pytest.approx(expected_sums, rel=3e-6, abs=1e-6)


FEW = np.array([3, 0, 1, 20, 2, 0, 9], np.uint32)
MANY = np.array([40, 5, 0, 2, 1, 0, 30], np.uint32)


def test_sums_are_those_of_a_loop():
    band = summed(0 * FEW, FEW, 1)
    assert 0 < dr.sum(band.invalid)[0] < FEW.sum()
    assert_same(band, by_loop((FEW, 1)))


def test_merged_sums_are_those_of_all_samples():
    """Of unequal numbers: one pixel has none in one part, another none in either."""
    band = summed(0 * FEW, FEW, 1)
    band.merge(summed(FEW, MANY, 2))
    assert_same(band, by_loop((FEW, 1), (MANY, 2)))
