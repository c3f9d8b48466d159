"""References: two halves, what they say of their own error, and how they are kept."""

import numpy as np
import pytest

from conftest import LIT
from tracer.image import metrics
from tracer.study import reference as references
from tracer.study.methods import Setting
from tracer.study.reference import FALSE_ALARM, Reference, cache_folder, make_reference, spp_of_chunk
from tracer.study.reference_half import Half, tile_means
from tracer.study.run import without_error_of

BALL = '<shape type="sphere"><point name="center" x="0.3" y="0" z="4"/></shape>'


def noisy(generator, chunks, truth, spread=0.1):
    half = Half.empty(16, *truth.shape[:2])
    for _ in range(chunks):
        half.add(truth + spread * generator.standard_normal(truth.shape))
    return half


def test_a_half_is_the_mean_of_its_chunks():
    generator = np.random.default_rng(0)
    chunks, variances = generator.random((2, 5, 12, 10, 3))
    half = Half.empty(16, 12, 10)
    for chunk, variance in zip(chunks, variances, strict=True):
        half.add(chunk, variance)
    np.testing.assert_allclose(half.mean, chunks.mean(axis=0))
    np.testing.assert_allclose(half.deviations, chunks.var(axis=0) * 5)
    np.testing.assert_allclose(half.variance, variances.mean(axis=0))
    assert (half.chunks, half.spp) == (5, 80)


def test_tiles():
    values = np.arange(7 * 5.0).reshape(7, 5)
    found = tile_means(values, (2, 5))
    np.testing.assert_allclose(found[0], values[:3].mean(axis=0))
    np.testing.assert_allclose(found[1], values[3:].mean(axis=0))


def test_its_own_error_is_measured():
    """The mean squared error that the halves tell is the true one, within four standard errors of 200 trials."""
    generator = np.random.default_rng(4)
    truth = generator.random((16, 16, 3))
    told, true = [], []
    for _ in range(200):
        one = Reference(noisy(generator, 4, truth), noisy(generator, 4, truth, 0.2))
        told.append(one.mse)
        true.append(np.mean((one.image - truth) ** 2))
    difference = np.array(told) - true
    assert abs(difference.mean()) < 4 * difference.std() / np.sqrt(200)


def test_halves_of_one_picture_agree():
    """300 trials at a false-alarm rate of 0.001: more than 4 alarms happen once in 30,000 times."""
    generator = np.random.default_rng(5)
    truth = generator.random((16, 16, 3))
    pairs = (Reference(noisy(generator, 8, truth), noisy(generator, 8, truth)) for _ in range(300))
    assert sum(not pair.halves_agree for pair in pairs) <= 4


def test_halves_of_two_pictures_do_not():
    generator = np.random.default_rng(6)
    truth = generator.random((16, 16, 3))
    other = truth.copy()
    other[4:8, 4:8] += 0.1  # one part of sixteen
    pair = Reference(noisy(generator, 8, truth), noisy(generator, 8, other))
    assert pair.disagreement < FALSE_ALARM
    assert not pair.halves_agree


def test_without_noise_halves_agree():
    half = noisy(np.random.default_rng(7), 4, np.ones((8, 8, 3)), 0.0)
    assert Reference(half, half).halves_agree


def test_chunks_are_powers_of_four():
    assert [spp_of_chunk(pixels) for pixels in (100, 2**16, 2**18, 2**24)] == [1024, 256, 64, 4]


def test_a_reference_of_a_scene(scene_file):
    scene = scene_file(LIT + BALL)
    found = make_reference(Setting(scene), 64)
    assert found.image.shape == (8, 12, 3)
    assert found.spp == 2 * references.LEAST_CHUNKS * 1024
    assert found.halves_agree
    assert 0 < found.mse < 1e-4
    assert found.variance.max() > 0


def test_halves_are_kept_by_content_and_added_to(scene_file, monkeypatch):
    scene = scene_file(LIT)
    first = make_reference(Setting(scene), 64)

    def refuse(*arguments, **options):
        raise AssertionError("rendered although it was kept")

    monkeypatch.setattr(references, "by_tracer", refuse)
    assert np.array_equal(make_reference(Setting(scene), first.spp).image, first.image)
    for change in ({"size": 9}, {"integrator": "direct"}):
        with pytest.raises(AssertionError, match="although it was kept"):
            make_reference(Setting(scene, **change), 64)
    with pytest.raises(AssertionError, match="although it was kept"):
        make_reference(Setting(scene), first.spp + 1)
    monkeypatch.undo()
    assert make_reference(Setting(scene), first.spp + 1).spp == first.spp + 2 * 1024
    scene.write_text(scene.read_text() + " ")
    monkeypatch.setattr(references, "by_tracer", refuse)
    with pytest.raises(AssertionError, match="although it was kept"):
        make_reference(Setting(scene), 64)


def test_chunks_are_kept_when_it_is_stopped(scene_file):
    setting = Setting(scene_file(LIT))
    seen = []

    def stop(done, total):
        seen.append(done)
        return len(seen) < 3

    with pytest.raises(KeyboardInterrupt):
        make_reference(setting, 64, stop)
    kept = [Half.load(path).chunks for path in sorted(cache_folder().rglob("*.npz"))]
    assert kept == [2, 1]
    whole = make_reference(setting, 64)
    cold = np.mean([half.mean for half in (whole.by_mitsuba, whole.by_tracer)], axis=0)
    np.testing.assert_array_equal(cold, whole.image)
    assert (whole.by_mitsuba.chunks, whole.by_tracer.chunks) == (4, 4)


def test_errors_are_measured_as_if_the_reference_had_none():
    """A noisy picture against a noisy reference: what is left is the error against the truth, at 3 standard errors."""
    rng = np.random.default_rng(4)
    shape, noise, own = (120, 160, 3), 0.05, 0.03
    truth = np.full(shape, 0.5)

    def half(spread):
        made = Half.empty(16, *shape[:2])
        made.mean = truth + rng.normal(0, spread, shape)
        return made

    reference = Reference(half(own * np.sqrt(2)), half(own * np.sqrt(2)))
    picture = truth + rng.normal(0, noise, shape)
    measured = metrics.all_scores(picture, reference.image)
    found = without_error_of(reference, measured)
    assert measured.mse == pytest.approx(noise**2 + own**2, rel=0.03)
    exact = float(np.mean((picture - truth) ** 2))
    spread = np.sqrt((4 * noise**2 * own**2 + 4 * own**4) / picture.size)
    assert abs(found.mse - exact) < 3 * spread
    nothing = without_error_of(reference, metrics.all_scores(reference.image, reference.image))
    assert nothing.mse == 0
