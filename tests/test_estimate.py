"""The estimate equals mi.render for equal counts, whatever the filter; its statistics equal NumPy's."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from conftest import FILTERS

from tracer import draw
from tracer.estimate import Estimate
from tracer.scene import open_scene


def draw_all(view, counts, *, seed=3, pass_size=1 << 20, first=None, estimate=None, keep=None):
    """Draw ``counts`` (grid) into an estimate; ``keep`` collects pixel, values of every sample."""
    estimate = estimate or Estimate(view)
    sampler = mi.load_dict({"type": "owen_sobol"})
    first = np.zeros(view.grid, np.uint32) if first is None else first
    for window in draw.Line(counts.ravel(), first.ravel()).passes(pass_size):
        pixel, index = draw.lane_pixels(window)
        samples = draw.draw(view, sampler, mi.UInt32(seed), pixel, index, mi.Float(0.25))
        dr.eval(samples.values, samples.position, pixel, index)
        if keep is not None:
            keep.append((np.array(pixel), np.array(index), np.stack([np.array(v) for v in samples.values], axis=-1)))
        estimate.add(window, samples)
    return estimate


def uneven(view):
    counts = np.random.default_rng(2).integers(0, 9, view.grid).astype(np.uint32)
    counts[3, 4] = 200
    return counts


@pytest.mark.parametrize("filter_name", FILTERS)
@pytest.mark.parametrize("border", [False, True])
def test_equal_counts_give_the_picture_of_mitsuba(cornell, filter_name, border):
    scene = cornell(filter_name=filter_name, sample_border=border)
    scene["sensor"]["sampler"] = {"type": "owen_sobol", "sample_count": 16}
    with open_scene(scene) as view:
        expected = np.array(view.integrator.render(view.scene, sensor=view.sensor, seed=3, spp=16))
        image, stderr = draw_all(view, np.full(view.grid, 16, np.uint32)).develop()
    assert image.shape == stderr.shape == expected.shape
    assert image == pytest.approx(expected, rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("pixel_format", ["luminance", "luminance_alpha", "rgba", "xyz", "xyza"])
def test_equal_counts_give_the_channels_of_mitsuba(cornell, pixel_format):
    scene = cornell(pixel_format=pixel_format)
    scene["sensor"]["sampler"] = {"type": "owen_sobol", "sample_count": 4}
    with open_scene(scene) as view:
        expected = np.array(view.integrator.render(view.scene, sensor=view.sensor, seed=3, spp=4))
        image, _ = draw_all(view, np.full(view.grid, 4, np.uint32)).develop()
    assert image == pytest.approx(expected, rel=1e-4, abs=1e-4)


def test_statistics_are_those_of_numpy(cornell):
    with open_scene(cornell()) as view:
        counts, kept = uneven(view), []
        statistics = draw_all(view, counts, keep=kept, pass_size=100).statistics()
        assert np.array_equal(statistics.count, counts)
        pixel, index, values = (np.concatenate(parts) for parts in zip(*kept, strict=True))
        for k in range(view.pixel_count):
            own = values[pixel == k].astype(np.float64)
            assert np.array_equal(np.sort(index[pixel == k]), np.arange(counts.flat[k]))
            if len(own):
                assert statistics.mean.reshape(-1, 3)[k] == pytest.approx(own.mean(axis=0), rel=1e-12)
            if len(own) > 1:
                expected = own.var(axis=0, ddof=1)
                assert statistics.variance.reshape(-1, 3)[k] == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_the_split_into_passes_and_rounds_changes_no_bit(cornell):
    with open_scene(cornell()) as view:
        counts = uneven(view)
        whole = draw_all(view, counts)
        passes = draw_all(view, counts, pass_size=37)
        half = counts // 2
        rounds = draw_all(view, counts - half, first=half, estimate=draw_all(view, half))
        expected, image = whole.statistics(), whole.develop()[0]
        for other in (passes, rounds):
            found = other.statistics()
            for name in ("count", "mean", "variance"):
                assert np.array_equal(getattr(found, name), getattr(expected, name)), name
            assert other.develop()[0] == pytest.approx(image, rel=1e-5, abs=1e-6)


def test_samples_that_are_not_finite_are_counted_and_left_out(cornell):
    with open_scene(cornell(size=(2, 1), filter_name="box")) as view:
        window = draw.Line(np.array([3, 2], np.uint32), np.zeros(2, np.uint32)).take(5)
        values = [mi.Float([1, np.nan, 3, np.inf, np.nan]), mi.Float([1, 1, 3, 1, 1]), mi.Float([2, 1, 4, 1, 1])]
        estimate = Estimate(view)
        estimate.add(window, draw.Samples(values, dr.full(mi.Point2f, 0.5, 5)))
        statistics, (image, stderr) = estimate.statistics(), estimate.develop()
    assert statistics.count.tolist() == [[2, 0]]
    assert statistics.invalid.tolist() == [[1, 2]]
    assert image.tolist() == [[[2, 2, 3], [0, 0, 0]]]
    assert stderr[0] == pytest.approx(np.array([[1, 1, 1], [0, 0, 0]]))


def test_dense_pixels_do_not_bleed_into_sparse_ones(cornell):
    """Two flat halves of different counts: each output pixel weighs its two sides as if the counts were equal."""
    with open_scene(cornell(size=(8, 8))) as view:
        counts = np.full(view.grid, 64, np.uint32)
        counts[:, 4:] = 1024
        column = np.repeat((np.arange(64) % 8 >= 4).astype(np.float32), counts.ravel())
        window = draw.Line(counts.ravel(), np.zeros(64, np.uint32)).take(int(counts.sum()))
        rng = np.random.default_rng(0)
        position = mi.Point2f(rng.random((2, len(column))).astype(np.float32))
        estimate = Estimate(view)
        estimate.add(window, draw.Samples([mi.Float(column)] * 3, position))
        image = estimate.develop()[0][4, :, 0]
    # By symmetry the two middle columns sum to one; bleeding would push both up.
    assert image[3] + image[4] == pytest.approx(1, abs=0.02)
    assert image[0] == pytest.approx(0, abs=1e-3)


def test_no_pixel_is_drawn_twice_between_windows():
    counts = np.array([0, 5, 0, 0, 7, 1, 0], np.uint32)
    first = np.array([2, 10, 0, 0, 100, 0, 0], np.uint32)
    drawn = []
    for window in draw.Line(counts, first).passes(4):
        pixel, index = draw.lane_pixels(window)
        drawn += zip(np.array(pixel).tolist(), np.array(index).tolist(), strict=True)
    expected = [(1, 10 + k) for k in range(5)] + [(4, 100 + k) for k in range(7)] + [(5, 0)]
    assert drawn == expected
