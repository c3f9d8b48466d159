"""The regression of the default criterion: its parts by loops and kernels, the whole by what must not matter to it."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import nnls

from tracer import criteria
from tracer.criteria import fused

from .made_up import evidence_of, light, statistics_of

GRID = (12, 14)


def window_mean(values, width):
    """Return the mean of width x width neighbours, the edge repeated."""
    padded = np.pad(np.asarray(values, np.float64), width // 2, mode="edge")
    height, columns = values.shape
    parts = [padded[r : r + height, c : c + columns] for r in range(width) for c in range(width)]
    return np.mean(parts, axis=0)


def blurred(values, deviation):
    """Return values under a Gaussian of 4 deviations to each side, the edge repeated."""
    reach = int(4 * deviation + 0.5)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation) ** 2)
    padded = np.pad(np.asarray(values, np.float64), reach, mode="edge")
    for axis in (0, 1):
        padded = np.apply_along_axis(np.convolve, axis, padded, kernel / kernel.sum(), mode="valid")
    return padded


def seen(seed=5):
    """Return what pilot rays see: Gini indices of shapes and faces."""
    shape, face = np.random.default_rng(seed).random((2, *GRID)) / 2
    return SimpleNamespace(shape_gini=shape, face_gini=face)


def test_the_error_of_means_is_that_of_the_last_samples():
    """(m_2 - m_1)^2 / (1 / n_1 + 1 / n_2), where the second mean is that of the new samples alone."""
    samples = light(11, *GRID)
    before, known = (statistics_of(samples[:count], "fused") for count in (3, 11))
    weight = np.random.default_rng(1).random(GRID)
    pixels = np.random.default_rng(4).permutation(weight.size).astype(np.uint32)[:100]
    found, is_known = fused.error_of_means(before, known, weight, 3, pixels)
    moved = samples[3:].mean(axis=0) - samples[:3].mean(axis=0)
    expected = weight * (moved**2).mean(axis=-1) / (1 / 3 + 1 / 8)
    assert found == pytest.approx(expected.ravel()[pixels], rel=1e-4)
    assert is_known.all()
    before.count.ravel()[pixels[:2]] = 11, 0
    found, is_known = fused.error_of_means(before, known, weight, 3, pixels)
    assert (found[0], found[1], is_known.sum()) == (0, 0, 98)


def test_predictors_are_variances_at_several_widths_and_the_contrast_that_is_more_than_noise():
    known = statistics_of(light(6, *GRID), "fused")
    known.count[:] = np.random.default_rng(2).integers(1, 60, GRID)
    weight = np.random.default_rng(3).uniform(0.5, 2, GRID)
    found = fused.predictors(known, weight, 3, fused.smooth_gini(seen()))
    variance = known.variance.astype(np.float64).mean(axis=-1) * weight
    mean = known.mean.astype(np.float64).mean(axis=-1)
    spread = window_mean(mean**2, 3) - window_mean(mean, 3) ** 2
    contrast = np.maximum(spread * weight - blurred(variance, 1.0) / known.count, 0)
    assert 0.1 < (contrast > 0).mean() < 0.9
    shape, face = window_mean(seen().shape_gini, 3), window_mean(seen().face_gini, 3)
    expected = [
        blurred(variance, 0.5),
        blurred(variance, 1.0),
        window_mean(variance, 7),
        window_mean(variance, 13),
        np.full(GRID, variance.mean()),
        contrast,
        contrast * shape,
        contrast * face,
        blurred(contrast, 1.0) * shape,
    ]
    for one, other in zip(found, expected, strict=True):
        assert one.numpy().reshape(GRID) == pytest.approx(other, rel=1e-3, abs=1e-4 * variance.mean())


def tall_fit(columns, observed):
    """Return the coefficients after four rounds of relative least squares, by the active set on the tall matrix."""
    prediction = (columns / columns.mean(axis=0)).mean(axis=1) * observed.mean()
    for _ in range(4):
        level = np.maximum(prediction, 1e-3 * prediction.mean())
        coefficients = nnls(columns / level[:, None], np.minimum(observed / level, 30))[0]
        prediction = columns @ coefficients
    return coefficients


def skewed_columns(number=3000):
    random = np.random.default_rng(4)
    columns = random.lognormal(0, 1.5, (number, 4)) * [1.0, 1e3, 1e-3, 1.0]
    expected = columns @ [0.3, 2e-3, 0.0, 1.0]
    return columns, expected, expected * random.chisquare(1, number)


def test_what_predictors_explain_is_found():
    columns, expected, _ = skewed_columns()
    assert fused.fit(columns, expected) == pytest.approx([0.3, 2e-3, 0, 1], rel=1e-3, abs=1e-3)


def test_what_says_nothing_has_no_say():
    """As variances do after a single sample."""
    columns, expected, _ = skewed_columns()
    columns[:, [0, 2]] = 0
    assert fused.fit(columns, expected)[[0, 2]].tolist() == [0, 0]


def test_coefficients_are_those_of_another_solver():
    columns, _, observed = skewed_columns()
    scale = columns.mean(axis=0)
    assert fused.fit(columns, observed) * scale == pytest.approx(
        tall_fit(columns, observed) * scale, rel=1e-3, abs=1e-3
    )


def test_one_firefly_does_not_fit_the_scene():
    columns, _, observed = skewed_columns()
    usual = columns @ fused.fit(columns, observed)
    observed[7] *= 1e8
    # It counts 30 times what was predicted, among 3000: at most a few percent, were it not for where it pulls.
    assert columns @ fused.fit(columns, observed) == pytest.approx(usual, rel=0.15)


def rounds(seed=0):
    """Return what is known after 4, 8 and 16 samples."""
    samples = light(16, *GRID, seed=seed)
    return [statistics_of(samples[:count], "fused") for count in (4, 8, 16)]


def importance(known, before=None, weight=1.0, weight_before=1.0, **rest):
    evidence = evidence_of(known, before, look=seen)
    evidence.weight[:] = weight
    changed = {"weight_before": None if before is None else np.full(GRID, weight_before), **rest}
    return criteria.get("fused").importance(type(evidence)(**{**vars(evidence), **changed}))


def test_importance_is_a_deviation_in_the_weight_of_now():
    """Four times the present weight is twice the deviation; what was fitted in the past has its own weight."""
    first, second, _ = rounds()
    usual = importance(second, first)
    assert importance(second, first, weight=4.0) == pytest.approx(2 * usual, rel=1e-5)
    assert importance(second, first, weight_before=4.0) == pytest.approx(usual, rel=1e-5)
    assert importance(first, weight=4.0) == pytest.approx(2 * importance(first), rel=1e-5)


def test_importance_is_the_deviation_of_a_sample_where_all_is_alike():
    """Independent samples of deviation 0.5: standard error 0.5 % of what is found from 4000 pixels twice."""
    samples = 0.5 * np.random.default_rng(8).normal(size=(8, 64, 64, 3))
    before, known = (statistics_of(samples[:count], "fused") for count in (4, 8))
    flat = SimpleNamespace(shape_gini=np.zeros((64, 64)), face_gini=np.zeros((64, 64)))
    found = criteria.get("fused").importance(evidence_of(known, before, look=lambda: flat))
    assert np.sqrt((found**2).mean()) == pytest.approx(0.5, rel=0.03)
    assert found.std() < 0.15 * found.mean()


def test_a_first_guess_leaves_no_pixel_out():
    """A tenth of the mean deviation is added, also where all samples were equal."""
    known = rounds()[0]
    known.variance[:] = 0.25
    assert importance(known) == pytest.approx(0.55, rel=1e-5)
    known.variance[:, :7] = 0
    assert importance(known)[:, 0] == pytest.approx(
        0.1 * (importance(known) - importance(known)[0, 0]).mean(), rel=1e-4
    )


def test_a_render_that_goes_on_decides_the_same():
    """With what is remembered from the last round, or with nothing, as after a checkpoint."""
    first, second, third = rounds()
    memory = {}
    importance(second, first, memory=memory)
    assert np.array_equal(importance(third, second, memory=memory), importance(third, second))


def test_errors_in_some_columns_are_seen():
    """Of 2^14 pixels half are looked at, but not every second one of them."""
    samples = light(8, 128, 128)
    samples[4:, :, ::2] = samples[:4, :, ::2]
    before, known = (statistics_of(samples[:count], "fused") for count in (4, 8))
    flat = SimpleNamespace(shape_gini=np.zeros((128, 128)), face_gini=np.zeros((128, 128)))
    assert criteria.get("fused").importance(evidence_of(known, before, look=lambda: flat)).mean() > 0
