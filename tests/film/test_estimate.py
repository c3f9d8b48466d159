"""The estimate equals mi.render for equal counts, whatever the filter; its statistics equal NumPy's."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from conformance.cases import FILTERS
from tracer.film.estimate import Estimate
from tracer.sampling import samples
from tracer.sampling.wavefront import Line, Stretch, lane_pixels, line_of
from tracer.scene.view import open_scene


def draw_all(view, counts, *, seed=3, pass_size=1 << 20, first=None, estimate=None, keep=None):
    """Draw ``counts`` (grid) into an estimate; ``keep`` collects pixel, values of every sample."""
    estimate = estimate or Estimate(view)
    sampler = mi.load_dict({"type": "owen_sobol"})
    first = np.zeros(view.grid, np.uint32) if first is None else first
    for window in Line(Stretch(0, first.ravel(), (first + counts).ravel())).passes(pass_size):
        pixel, index = lane_pixels(window)
        drawn = samples.draw(view, sampler, mi.UInt32(seed), pixel, index, mi.Float(0.25))
        dr.eval(drawn.values, drawn.position, pixel, index)
        if keep is not None:
            keep.append((np.array(pixel), np.array(index), np.stack([np.array(v) for v in drawn.values], axis=-1)))
        estimate.add(window, drawn)
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
                assert statistics.mean.reshape(-1, 3)[k] == pytest.approx(own.mean(axis=0), rel=1e-6)
            if len(own) > 1:
                expected = own.var(axis=0, ddof=1)
                assert statistics.variance.reshape(-1, 3)[k] == pytest.approx(expected, rel=1e-6, abs=1e-15)


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
        window = line_of(np.array([3, 2], np.uint32)).take(5)
        values = [mi.Float([1, np.nan, 3, np.inf, np.nan]), mi.Float([1, 1, 3, 1, 1]), mi.Float([2, 1, 4, 1, 1])]
        estimate = Estimate(view)
        estimate.add(window, samples.Samples(values, dr.full(mi.Point2f, 0.5, 5), dr.ones(mi.Float, 5)))
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
        window = line_of(counts.ravel()).take(int(counts.sum()))
        rng = np.random.default_rng(0)
        position = mi.Point2f(rng.random((2, len(column))).astype(np.float32))
        estimate = Estimate(view)
        estimate.add(window, samples.Samples([mi.Float(column)] * 3, position, mi.Float(column)))
        image = estimate.develop()[0][4, :, 0]
    # By symmetry the two middle columns sum to one; bleeding would push both up.
    assert image[3] + image[4] == pytest.approx(1, abs=0.02)
    assert image[0] == pytest.approx(0, abs=1e-3)


def same_statistics(found, expected):
    return all(np.array_equal(getattr(found, n), getattr(expected, n)) for n in ("count", "mean", "variance"))


def test_the_number_of_threads_changes_no_bit(cornell):
    threads = dr.thread_count()
    with open_scene(cornell()) as view:
        counts = uneven(view)
        expected = draw_all(view, counts).statistics()
        try:
            dr.set_thread_count(1)
            assert same_statistics(draw_all(view, counts).statistics(), expected)
        finally:
            dr.set_thread_count(threads)


@pytest.mark.parametrize(("band_pixels", "band_count"), [(100, 4), (10, 39)])
def test_pixels_of_several_bands_are_those_of_one(cornell, monkeypatch, band_pixels, band_count):
    """Also where the filter reaches beyond the next band."""
    with open_scene(cornell()) as view:
        counts = uneven(view)
        one = draw_all(view, counts)
        monkeypatch.setattr("tracer.film.pixel_sums.BAND_PIXELS", band_pixels)
        several = draw_all(view, counts, pass_size=500)
        assert (len(one.bands), len(several.bands)) == (1, band_count)
        assert same_statistics(several.statistics(), one.statistics())
        assert all(np.array_equal(a, b) for a, b in zip(several.develop(), one.develop(), strict=True))


@pytest.mark.parametrize("filter_name", ["box", "gaussian"])
def test_parts_merge_into_the_whole(cornell, filter_name):
    """Disjoint pixels bit for bit; ranges of samples, whose sums are rounded in another order, to float32."""
    with open_scene(cornell(filter_name=filter_name)) as view:
        counts = uneven(view)
        expected = draw_all(view, counts)
        image, stderr = expected.develop()
        left = counts.copy()
        left[:, 12:] = 0
        by_pixel = draw_all(view, left)
        by_pixel.merge(draw_all(view, counts - left))
        assert same_statistics(by_pixel.statistics(), expected.statistics())
        by_sample = draw_all(view, counts // 2)
        sent = Estimate(view)
        sent.restore(draw_all(view, counts - counts // 2, first=counts // 2).state())
        by_sample.merge(sent)
        for name in ("count", "mean", "variance"):
            found, wanted = (getattr(e.statistics(), name) for e in (by_sample, expected))
            assert found == pytest.approx(wanted, rel=3e-7, abs=1e-15)
        for merged in (by_pixel, by_sample):
            assert merged.develop()[0] == pytest.approx(image, rel=1e-5, abs=1e-6)
            assert merged.develop()[1] == pytest.approx(stderr, rel=1e-5, abs=1e-6)


def test_sums_of_another_view_are_refused(cornell):
    with (
        open_scene(cornell()) as view,
        open_scene(cornell(size=(4, 4))) as other,
        open_scene(cornell((16, 24))) as high,
    ):
        own, others, turned = (Estimate(each).state() for each in (view, other, high))
        for state in (others, turned, own[:-1], [*own, np.zeros(1)]):
            with pytest.raises(ValueError, match="another view"):
                Estimate(view).restore(state)


@pytest.mark.parametrize("filter_name", ["box", "tent", "gaussian"])
def test_a_hundred_thousand_samples_lose_no_precision(cornell, filter_name):
    """0.1 in float32 added so often is off by percents; and one bright sample in a thousand must not be."""
    spp, rng = 100_000, np.random.default_rng(0)
    with open_scene(cornell(size=(3, 3), filter_name=filter_name)) as view:
        estimate = Estimate(view)
        rare = np.where(np.arange(spp * 9) % 1000 == 7, 50.0, 0.1).astype(np.float32)
        for part in range(4):
            counts = np.full(9, spp // 4, np.uint32)
            window = Line(Stretch(0, counts * part, counts * (part + 1))).take(int(counts.sum()))
            lanes = slice(part * window.sample_count, (part + 1) * window.sample_count)
            position = mi.Point2f(rng.random((2, window.sample_count)).astype(np.float32))
            constant = dr.full(mi.Float, 0.1, window.sample_count)
            estimate.add(window, samples.Samples([constant, mi.Float(rare[lanes]), constant], position, constant))
        image, _ = estimate.develop()
        statistics = estimate.statistics()
    assert image[..., 0] == pytest.approx(0.1, rel=5e-5)
    exact = 0.1 + 0.001 * (50 - 0.1)
    assert statistics.mean[..., 1] == pytest.approx(exact, rel=1e-6)
    assert statistics.variance[..., 1] == pytest.approx(0.001 * 0.999 * 49.9**2, rel=1e-4)
    if filter_name == "box":
        assert image[..., 1] == pytest.approx(exact, rel=1e-6)


def tent(distance):
    return np.maximum(1 - np.abs(distance), 0)


def test_picture_and_standard_errors_are_those_of_loops(cornell):
    """Through a tent of radius 1, around pixels of unequal counts, one of which has no sample."""
    random = np.random.default_rng(6)
    with open_scene(cornell(size=(5, 4), filter_name="tent", sample_border=True)) as view:
        (height, width), border = view.grid, view.border
        assert border == 1
        counts = random.integers(1, 7, view.grid).astype(np.uint32)
        counts[2, 3] = 0
        number = int(counts.sum())
        values = (random.lognormal(0, 1, (number, 3)) * [1.0, 3.0, 0.2]).astype(np.float32)
        position = random.random((2, number)).astype(np.float32)
        estimate = Estimate(view)
        device = [mi.Float(np.ascontiguousarray(channel)) for channel in values.T]
        estimate.add(line_of(counts.ravel()).take(number), samples.Samples(device, mi.Point2f(position), device[0]))
        image, stderr = estimate.develop()
    pixel = np.repeat(np.arange(height * width), counts.ravel())
    row, column = np.divmod(pixel, width)
    own = [values[pixel == k] for k in range(height * width)]
    degrees = np.maximum(counts - 1.0, 0)
    spread = np.array([((each - each.mean(axis=0)) ** 2).sum(axis=0) if len(each) else np.zeros(3) for each in own])
    spread = spread.reshape(height, width, 3)
    around = [uniform_filter(each, 7, mode="nearest") for each in (*np.moveaxis(spread, -1, 0), degrees)]
    variance = (16 * np.stack(around[:3], axis=-1) / around[3][..., None] + spread) / (16 + degrees)[..., None]
    for y, x in np.ndindex(*image.shape[:2]):
        weight = tent(x + border + 0.5 - column - position[0]) * tent(y + border + 0.5 - row - position[1])
        weight = weight / counts.ravel()[pixel]
        share = np.bincount(pixel, weight, height * width) / weight.sum()
        assert image[y, x] == pytest.approx(weight @ values / weight.sum(), rel=1e-4)
        per_pixel = variance.reshape(-1, 3) / np.maximum(counts.reshape(-1, 1), 1)
        assert stderr[y, x] == pytest.approx(np.sqrt(share**2 @ per_pixel), rel=1e-4)


def test_a_pixel_that_no_sample_reaches_is_black(cornell):
    with open_scene(cornell(size=(8, 8))) as view:
        counts = np.zeros(view.grid, np.uint32)
        counts[:, :2] = 4
        image, stderr = draw_all(view, counts).develop()
    assert np.all(image[:, -2:] == 0)
    assert np.all(stderr[:, -2:] == 0)
    assert image[:, :2].min() > 0


def test_work_and_moments_are_means_and_peaks_are_maxima(cornell):
    random = np.random.default_rng(7)
    with open_scene(cornell(size=(3, 2))) as view:
        counts = np.array([[4, 0, 1], [2, 9, 3]], np.uint32)
        pixel = np.repeat(np.arange(6), counts.ravel())
        vertices, *drawn = (5 * random.random((6, len(pixel)))).astype(np.float32)
        estimate = Estimate(view, moments=2, peaks=2)
        moments, peaks = ([mi.Float(each) for each in several] for several in (drawn[:2], drawn[2:4]))
        position = dr.full(mi.Point2f, 0.5, len(pixel))
        bad = drawn[4].copy()
        bad[0] = np.nan
        all_samples = samples.Samples([mi.Float(bad)] * 3, position, mi.Float(vertices), moments, peaks)
        estimate.add(line_of(counts.ravel()).take(len(pixel)), all_samples)
        found = estimate.statistics()
        assert np.array_equal(estimate.drawn(), counts)
        assert estimate.samples().tolist() == [[3, 0, 1], [2, 9, 3]]
        with pytest.raises(ValueError, match="another view"):
            Estimate(view, moments=1, peaks=3).restore(estimate.state())
    packet = np.arange(len(pixel)) // 16
    longest = np.array([vertices[packet == packet[lane]].max() for lane in range(len(pixel))])
    work = 1 + (longest > 1) + np.maximum(longest - 2, 0) + 5 * np.maximum(vertices - 2, 0)
    for k in range(6):
        own = (pixel == k) & np.isfinite(bad)
        mean = [each[own].mean() if own.any() else 0 for each in (work, *drawn[:2])]
        most = [each[own].max(initial=-np.inf) for each in drawn[2:4]]
        assert [found.work.flat[k], *found.moments.reshape(6, 2)[k]] == pytest.approx(mean, rel=1e-5)
        assert list(found.peaks.reshape(6, 2)[k]) == most


@pytest.mark.parametrize("size", [(1, 1), (5, 1)])
def test_nothing_is_drawn_of_a_small_picture(cornell, size):
    with open_scene(cornell(size=size)) as view:
        estimate = Estimate(view, moments=1, peaks=2)
        image, stderr = estimate.develop()
        assert all(np.array_equal(a, b) for a, b in zip(estimate.blank(), estimate.state(), strict=True))
        assert np.all(estimate.statistics().peaks == -np.inf)
    assert image.shape == stderr.shape == (size[1], size[0], 3)
    assert not image.any()
    assert not stderr.any()
